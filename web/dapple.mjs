/* dapple.mjs - coherent shadow maps (csm.h) for pages: built in a worker, asked by shaders of the page's own, on the page's own
   WebGL 2 context. dapple.d.ts has the types, docs/web.md a tour, three.mjs a page of three.js with it. */
import createProgram from './dapple.wasm.mjs';

class DappleError extends Error {}

const numbers = (count) => Array(count).fill('number');

/* The program's memory. Where threads share it, its growth leaves the views of before too short. */
const memory = (program) => program.wasmMemory ? new Uint8Array(program.wasmMemory.buffer) : program.HEAPU8;

/* Copies an array into the program's memory; give it back by program._free. */
function put(program, array) {
    const bytes = new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
    const at = program._malloc(bytes.length || 1);
    if (!at) throw new DappleError('out of memory');
    memory(program).set(bytes, at);
    return at;
}

function last(program) {
    return new DappleError(program.ccall('dp_error', 'string', [], []));
}

/* ---- building: here, or in a worker ---- */

/* Threads need memory that workers share, which browsers give to pages that their server isolates from others, by two headers:
   Cross-Origin-Opener-Policy: same-origin, Cross-Origin-Embedder-Policy: require-corp. */
export const mayThread = () => globalThis.crossOriginIsolated === true && typeof SharedArrayBuffer === 'function';

/* The program and how many threads it has: `wanted`, or one of each processor, up to eight, where the page may; else one. */
async function programWithThreads(wanted, onProgress) {
    const threads = mayThread() ? Math.floor(Math.min(8, Math.max(1, wanted ?? navigator.hardwareConcurrency ?? 1))) : 1;
    if (!(threads > 1)) return { program: await createProgram({ onProgress }), threads: 1 };
    const { default: create } = await import('./dapple.threads.mjs'), program = await create({ onProgress, poolSize: threads - 1 });
    return { program, threads: program.ccall('dp_threads', 'number', ['number'], [threads]) };
}

/* Builds in this thread, which waits, and in workers of its own: for workers of yours. The block is a file of csm.h; its bytes
   do not depend on the threads. */
export async function buildHere(mesh, { side = 64, mapSide = 128, layers = 0, threads: wanted, onProgress, onThreads } = {}) {
    const { program, threads } = await programWithThreads(wanted, (f) => onProgress && onProgress(f) === false);
    try {
        const positions = put(program, Float32Array.from(mesh.positions)),
            indices = mesh.indices ? put(program, Uint32Array.from(mesh.indices)) : 0;
        const maps = program.ccall('dp_build', 'number', numbers(7), [positions, mesh.positions.length / 3, indices,
            mesh.indices ? mesh.indices.length : 0, side, mapSide, layers]);
        program._free(positions);
        program._free(indices);
        if (!maps) throw last(program);
        if (onThreads) onThreads(threads > 1 ? program.ccall('dp_took_part', 'number', [], []) : 1);
        const at = program.ccall('dp_block', 'number', ['number'], [maps]);
        const bytes = program.ccall('dp_block_bytes', 'number', ['number'], [maps]);
        return Uint8Array.from(memory(program).subarray(at, at + bytes));       // not of shared memory, which messages cannot hand over
    } finally {
        if (threads > 1) {
            program.ccall('dp_threads', 'number', ['number'], [1]);
            program.PThread.terminateAllThreads();
        }
    }
}

/* Builds in a worker, which ends with the build or when options.signal aborts. */
export function build(mesh, { onProgress, onThreads, signal, ...options } = {}) {
    return new Promise((resolve, reject) => {
        if (signal?.aborted) throw new DappleError('cancelled');
        const copy = { positions: Float32Array.from(mesh.positions), indices: mesh.indices ? Uint32Array.from(mesh.indices) : null };
        const worker = new Worker(new URL('./dapple.worker.mjs', import.meta.url), { type: 'module' });
        const abort = () => end(reject, new DappleError('cancelled'));
        const end = (settle, value) => {
            worker.terminate();
            signal?.removeEventListener('abort', abort);
            settle(value);
        };
        signal?.addEventListener('abort', abort);
        worker.onerror = (event) => end(reject, new DappleError(event.message || 'the worker could not be started'));
        worker.onmessage = ({ data }) => {
            if (data.fraction !== undefined) { if (onProgress) onProgress(data.fraction); }
            else if (data.threads !== undefined) { if (onThreads) onThreads(data.threads); }
            else if (data.error !== undefined) end(reject, new DappleError(data.error));
            else end(resolve, data.block);
        };
        try {
            worker.postMessage({ mesh: copy, options });
        } catch (error) {                           // an option that cannot be sent
            end(reject, error);
        }
    });
}

/* ---- on a context ---- */

/* Texture units firstUnit and firstUnit + 1 and the uniform buffer binding firstBlock become ours while maps are bound. */
export async function attach(context, { firstUnit = 12, firstBlock = 6 } = {}) {
    const program = await createProgram({});
    const handle = program.GL.registerContext(context, { majorVersion: 2, minorVersion: 0, enableExtensionsByDefault: true });
    program.GL.makeContextCurrent(handle);
    const gl = program.ccall('dp_attach', 'number', numbers(2), [firstUnit, firstBlock]);
    if (!gl) throw last(program);
    return new Attached(program, handle, gl);
}

class Attached {
    #program; #handle; #gl; #maps = new Set();

    constructor(program, handle, gl) {
        this.#program = program;
        this.#handle = handle;
        this.#gl = gl;
    }

    #call(name, result, types, values) {
        this.#program.GL.makeContextCurrent(this.#handle);
        return this.#program.ccall(name, result, types, values);
    }

    /* Uploads blocks, with room for so many instances of them; none is placed yet. */
    maps(blocks, capacity = blocks.length) {
        const program = this.#program, opened = [];
        try {
            for (const block of blocks) {
                const at = put(program, block), maps = program.ccall('dp_open', 'number', numbers(2), [at, block.length]);
                program._free(at);
                if (!maps) throw last(program);
                opened.push(maps);
            }
            const list = put(program, Uint32Array.from(opened));
            const scene = this.#call('dp_scene_create', 'number', numbers(4), [this.#gl, list, opened.length, capacity]);
            program._free(list);
            if (!scene) throw last(program);
            const made = new Maps(program, (...a) => this.#call(...a), this.#gl, scene, () => this.#maps.delete(made));
            this.#maps.add(made);
            return made;
        } finally {
            for (const maps of opened) program.ccall('dp_free', null, ['number'], [maps]);
        }
    }

    /* The library's GLSL for a fragment or vertex shader of GLSL ES 3.00, to stand before your functions and behind #version.
       defines: those of the maps make it fast, and right for maps with the same defines only. */
    glsl({ uses = 'csm_visible', defines = '' } = {}) {
        const text = this.#call('dp_glsl', 'string', ['number', 'string', 'string'], [this.#gl, uses, defines]);
        if (!text) throw last(this.#program);
        return text;
    }

    /* Once for each program that you have linked with glsl(). */
    setSlots(webglProgram) {
        const GL = this.#program.GL, name = GL.getNewId(GL.programs);
        GL.programs[name] = webglProgram;
        /* What Emscripten's glCreateProgram and glLinkProgram would have noted. */
        Object.assign(webglProgram, { name, uniformIdCounter: 1, uniformLocsById: 0, uniformSizeAndIdsByName: {},
            maxUniformLength: 0, maxAttributeLength: 0, maxUniformBlockNameLength: 0 });
        const result = this.#call('dp_set_slots', 'number', numbers(2), [this.#gl, name]);
        GL.programs[name] = null;
        if (result !== 0) throw last(this.#program);
    }

    /* Frees its maps, too. lost: after the event webglcontextlost. */
    free({ lost = false } = {}) {
        if (lost) this.#call('dp_lost', null, ['number'], [this.#gl]);
        for (const maps of [...this.#maps]) maps.free();
        this.#call('dp_detach', null, ['number'], [this.#gl]);
    }
}

class Maps {
    #program; #call; #gl; #scene; #freed;

    constructor(program, call, gl, scene, freed) {
        this.#freed = freed;
        this.#program = program;
        this.#call = call;
        this.#gl = gl;
        this.#scene = scene;
        this.defines = call('dp_scene_defines', 'string', ['number'], [scene]);
    }

    /* After free there is neither a scene nor perhaps a context for it, which the program would read all the same. */
    #living() {
        if (!this.#scene) throw new Error('these maps were freed');
        return this.#scene;
    }

    /* Replaces all instances: [{ block: 0, matrix: 16 numbers, object to world }]. The shader counts them from 1. */
    place(instances) {
        const scene = this.#living();
        const matrices = put(this.#program, Float32Array.from(instances.flatMap((i) => [...i.matrix]))),
            blocks = put(this.#program, Uint32Array.from(instances.map((i) => i.block || 0)));
        const result = this.#call('dp_scene_place', 'number', numbers(5), [this.#gl, scene, matrices, blocks, instances.length]);
        this.#program._free(matrices);
        this.#program._free(blocks);
        if (result !== 0) throw last(this.#program);
    }

    /* Binds textures and uniform block; they stay bound until somebody takes their units. */
    bind() { this.#call('dp_bind', null, numbers(2), [this.#gl, this.#living()]); }

    free() {
        if (!this.#scene) return;
        this.#call('dp_scene_free', null, numbers(2), [this.#gl, this.#scene]);
        this.#scene = 0;
        this.#freed();
    }
}
