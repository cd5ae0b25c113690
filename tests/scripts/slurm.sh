#!/bin/sh
# slurm.sh COMMAND... - runs a command with a private Slurm of one machine: a controller and a node of two processors,
# with a munge key, ports and a folder of their own, for sbatch, squeue and scontrol. All of it ends with the command,
# or after LIFE seconds (240) where this script was killed outright. Nobody else can submit to it, and no cluster that
# is there already is asked. Status: the command's, or 77, with the reason, where no Slurm can be started.
PATH=$PATH:/usr/sbin:/sbin
life=${LIFE:-240}
dir=$(mktemp -d) || exit 1
started='' command=''
leave() {
    echo "skip: $1"
    exit 77
}
end() {
    status=$?
    trap - EXIT
    trap '' HUP INT TERM
    if [ -n "$command" ]; then
        kill "$command" 2>/dev/null
        [ -z "$(timeout 10 squeue -h)" ] || { timeout 10 scancel --user="$user"; sleep 2; }
    fi
    # shellcheck disable=SC2086
    [ -z "$started" ] || kill $started 2>/dev/null
    wait
    rm -rf "$dir"
    exit $status
}
trap end EXIT
trap 'exit 129' HUP
trap 'exit 130' INT
trap 'exit 143' TERM

# daemon NAME COMMAND...: in the background; what it says goes to NAME.log
daemon() {
    log=$dir/$1.log
    shift
    timeout -k 5 "$life" "$@" > "$log" 2>&1 &
    started="$! $started"
}

for program in slurmctld slurmd sbatch munged; do
    command -v $program >/dev/null 2>&1 || leave "$program is not installed"
done
for name in $(env | sed -n 's/^\(S\(LURM\|BATCH\|INFO\|QUEUE\)_[A-Z_]*\)=.*/\1/p'); do unset "$name"; done

user=$(id -un) host=$(uname -n)
host=${host%%.*}
mkdir "$dir/state" "$dir/spool"
(umask 077; dd if=/dev/urandom of="$dir/munge.key" bs=128 count=1 2>/dev/null)
# --force: it warns of a socket in a folder that others cannot enter.
daemon munge munged --foreground --force --num-threads=2 --key-file="$dir/munge.key" --socket="$dir/munge.socket" \
    --pid-file="$dir/munge.pid" --seed-file="$dir/munge.seed" --log-file="$dir/munged.log"
export SLURM_CONF="$dir/slurm.conf"
port=$((20000 + $$ % 6000))
# Nothing here uses control groups, and 24.11 must be told; 22.05 does not know the word.
case $(slurmctld -V) in *' 2'[0-2].*) ;; *) echo 'CgroupPlugin=disabled' > "$dir/cgroup.conf" ;; esac
# Both listen at this machine's own name alone, as nodes find each other.
cat > "$SLURM_CONF" <<END
ClusterName=farm
SlurmctldHost=$host
SlurmctldPort=$port
SlurmdPort=$((port + 6000))
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
AuthInfo=socket=$dir/munge.socket
CredType=cred/munge
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/slurmd.pid
MailProg=/bin/true
ProctrackType=proctrack/pgid
TaskPlugin=task/none
MpiDefault=none
SwitchType=switch/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=batch_sched_delay=0
SlurmdParameters=config_overrides
ReturnToService=2
NodeName=$host CPUs=2 State=UNKNOWN
PartitionName=farm Nodes=$host Default=YES MaxTime=10 State=UP
END

alive() { for pid in $started; do kill -0 "$pid" 2>/dev/null || return; done; }
# await COMMAND...: until it is true; not where a daemon has ended, or after 20 seconds
await() {
    tries=0
    until "$@"; do
        tries=$((tries + 1))
        if [ $tries = 100 ] || ! alive; then
            reason=$(grep -h 'atal: ' "$dir"/*.log || grep -h 'rror: ' "$dir"/*.log)
            leave "Slurm does not start: $(echo "$reason" | tail -n 1)"
        fi
        sleep 0.2
    done
}
idle() { [ "$(timeout 10 sinfo -h -o %T 2>/dev/null)" = idle ]; }

await test -S "$dir/munge.socket"
daemon slurmctld slurmctld -D
daemon slurmd slurmd -D
await idle
"$@" &
command=$!
wait $command
