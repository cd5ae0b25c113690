/* product.js - the page "product": files, and what the user does with them, turned into calls of product.c. The maps of a
   model are built by a second copy of the program in a worker, coarse ones first, so that shadows are there at once and
   grow finer. */
'use strict';

const SIDES = [[16, 64], [48, 128], [96, 128]];     // maps a side of the directions, pixels a side of a map

Object.assign(state, { worker: null, model: 'builtin:knot', sky: 'builtin:sky', files: new Map(), block: null, blockOf: '', stages: [], shown: false });
const call = (name, types, ...values) => callC('pd', name, types, values);

/* ---- building ---- */

/* The worker's own program: it is this text, with that of product.wasm.js before it, since a page from the disk may not
   fetch scripts for workers. */
function work() {
    self.onmessage = async (event) => {
        const { name, bytes, sides } = event.data;
        const told = (fraction) => { self.postMessage({ fraction }); return false; };
        const program = await self.DappleProduct({ onProgress: told, print: () => {}, printErr: () => {} });
        const text = (f) => program.ccall(f, 'string', [], []);
        if (bytes) program.FS.writeFile(name, bytes);
        if (program.ccall('pd_load', 'number', ['string'], [name]) !== 0)
            return self.postMessage({ error: text('pd_error') });
        for (const [side, map] of sides) {
            const started = performance.now();
            self.postMessage({ stage: side });
            if (program.ccall('pd_build', 'number', ['number', 'number'], [side, map]) !== 0)
                return self.postMessage({ error: text('pd_error') });
            const at = program.ccall('pd_block', 'number', [], []), size = program.ccall('pd_block_bytes', 'number', [], []);
            const block = program.HEAPU8.slice(at, at + size);
            self.postMessage({ block, side, ms: performance.now() - started }, [block.buffer]);
        }
        self.postMessage({ done: true });
    };
}

function stop() {
    if (state.worker) state.worker.terminate();
    state.worker = null;
    element('work').style.display = 'none';
}

function build() {
    const script = 'var _scriptDir = ""; self.DappleProduct = ' + DappleProduct.toString() + ';(' + work.toString() + ')();';
    const url = URL.createObjectURL(new Blob([script], { type: 'text/javascript' }));
    stop();
    state.stages = [];
    state.worker = new Worker(url);
    URL.revokeObjectURL(url);
    element('work').style.display = 'flex';
    element('progress').value = 0;
    state.worker.onerror = (event) => { say('building failed: ' + event.message); stop(); };
    state.worker.onmessage = ({ data }) => {
        if (data.fraction !== undefined) element('progress').value = data.fraction;
        if (data.error) { say(data.error); stop(); }
        if (data.block) {
            state.stages.push(data.side);
            give(data.block);
            element('facts').textContent = `${data.side} x ${data.side} maps, ${(data.block.length / 1e6).toFixed(1)} MB, ` +
                `built in ${(data.ms / 1000).toFixed(1)} s`;
        }
        if (data.done) stop();
    };
    state.worker.postMessage({ name: state.model, bytes: state.files.get(state.model), sides: SIDES });
}

/* Drivers compile the shaders when something is first drawn by them: a few pixels with maps of four directions, while the worker
   builds those that will be seen. */
function warm() {
    const at = (name) => state.program.ccall(`pd_${name}`, 'number', [], []);
    if (!call('build', ['number', 'number'], 2, 16) || !call('open', ['number', 'number'], at('block'), at('block_bytes'))) return;
    canvas.width = canvas.height = 16;
    if (call('size', ['number', 'number'], 16, 16)) draw(1, 1);
    state.context.flush();
}

/* Takes a block of csm.h as the maps of the model. */
function give(block) {
    const at = state.program._malloc(block.length);
    let good = at !== 0;
    if (good) {
        state.program.HEAPU8.set(block, at);
        good = call('open', ['number', 'number'], at, block.length);
        state.program._free(at);
    } else say('out of memory');
    if (!good) return false;
    state.block = block;
    state.blockOf = state.model;
    element('save').disabled = false;
    state.ready = state.anew = true;
    return true;
}

/* ---- models, skies, files ---- */

function load(name) {
    say('');
    const before = state.model;
    if (state.files.has(name)) state.program.FS.writeFile(name, state.files.get(name));
    const good = call('load', ['string'], name);
    if (state.files.has(name)) state.program.FS.unlink(name);
    if (!good) { state.files.delete(name); pick('model', before); return; }
    state.model = name;
    state.ready = false;
    element('save').disabled = true;
    element('facts').textContent = `${state.program.ccall('pd_triangles', 'number', [], [])} triangles`;
    build();
    if (!state.shown) warm();
}

function loadSky(name) {
    const before = state.sky;
    if (state.files.has(name)) state.program.FS.writeFile(name, state.files.get(name));
    const good = call('sky', ['string'], name);
    if (state.files.has(name)) state.program.FS.unlink(name);
    if (!good) { state.files.delete(name); pick('sky', before); return; }
    say('');
    state.sky = name;
    state.anew = true;
}

function pick(list, value) {
    const select = element(list);
    if (![...select.options].some((o) => o.value === value)) select.add(new Option(value.replace(/^builtin:/, ''), value));
    select.value = value;
}

async function take(file) {
    const bytes = new Uint8Array(await file.arrayBuffer());
    const name = file.name.replace(/[^A-Za-z0-9._-]/g, '_');
    if (/\.glb$/i.test(name)) {
        state.files.set(name, bytes);
        load(name);
        if (state.model === name) pick('model', name);
    } else if (/\.hdr$/i.test(name)) {
        state.files.set(name, bytes);
        loadSky(name);
        if (state.sky === name) pick('sky', name);
    } else if (/\.csm$/i.test(name)) {
        say('');
        if (give(bytes)) { stop(); element('facts').textContent = `maps from ${name}, ${(bytes.length / 1e6).toFixed(1)} MB`; }
    } else say(`${name}: drop a .glb, a .hdr or saved maps (.csm)`);
}

/* ---- frames ---- */

function size() {
    resized();
    return call('size', ['number', 'number'], canvas.width, canvas.height);
}

function draw(samples, anew) {
    return call('frame', ['number', 'number', 'number', 'number', 'number', 'number', 'number', 'number', 'number'], view.azimuth,
        view.elevation, view.distance, view.up, element('turn').value * Math.PI / 180, 2 ** element('exposure').value,
        samples, element('show').checked ? 1 : 0, anew);
}

function frame() {
    if (!size()) return;
    const frames = state.program.ccall('pd_frames', 'number', [], []);
    if (!state.anew && frames >= FULL) return;
    const anew = state.anew ? 1 : 0;
    state.anew = false;
    draw(state.shown ? 2 ** element('samples').value : 1, anew);        // the first picture comes soonest
    state.shown = true;
    drawn(state.program.ccall('pd_frames', 'number', [], []));
}

/* ---- what the user does ---- */

function listenToFiles() {
    for (const id of ['turn', 'exposure', 'samples', 'show']) element(id).addEventListener('input', moved);
    element('model').addEventListener('change', () => load(element('model').value));
    element('sky').addEventListener('change', () => loadSky(element('sky').value));
    element('open').addEventListener('change', (e) => { for (const file of e.target.files) take(file); e.target.value = ''; });
    element('cancel').addEventListener('click', stop);
    element('save').addEventListener('click', save);
    document.addEventListener('dragover', (e) => { e.preventDefault(); element('stage').classList.add('over'); });
    document.addEventListener('dragleave', () => element('stage').classList.remove('over'));
    document.addEventListener('drop', async (e) => {
        e.preventDefault();
        element('stage').classList.remove('over');
        for (const file of e.dataTransfer.files) await take(file);
    });
}

function save() {
    const link = document.createElement('a');
    link.href = URL.createObjectURL(new Blob([state.block]));
    link.download = state.blockOf.replace(/^builtin:/, '').replace(/\.glb$/i, '') + '.csm';
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/* ---- start ---- */

/* A context that comes back has nothing of ours: model, sky and maps are given to it again. */
function begin() {
    const put = (name) => { if (state.files.has(name)) state.program.FS.writeFile(name, state.files.get(name)); };
    if (!call('start', []) || !size()) return false;
    put(state.sky);
    if (!call('sky', ['string'], state.sky)) return false;
    if (!state.block) { load(state.model); return true; }
    put(state.model);
    return call('load', ['string'], state.model) && give(state.block);
}

for (const name of ['knot', 'plant', 'robots', 'figure']) pick('model', 'builtin:' + name);
for (const name of ['sky', 'overcast', 'studio']) pick('sky', 'builtin:' + name);
element('model').value = state.model;
element('sky').value = state.sky;
listen({});
listenToFiles();
startPage({ create: DappleProduct, begin, frame, lose() { state.program.ccall('pd_lost', null, [], []); } });
