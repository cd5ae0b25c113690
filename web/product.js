/* product.js - the page "product": files, and what the user does with them, turned into calls of product.c. The maps of a
   model are built by a second copy of the program in a worker, coarse ones first, so that shadows are there at once and
   grow finer. Of the model that the page begins with, the coarse ones come with the page (first.cjs). */
'use strict';

const SIDES = [[16, 32], [48, 128], [96, 128]];     // maps a side of the directions, pixels a side of a map
const FIRST = 0.5, FIRST_SAMPLES = 2;               // the first picture has pixels of twice the size and few samples, to come soon; all of them follow
const number = (id) => { const e = element(id); return e.type === 'checkbox' ? +e.checked : +e.value; };
/* A limit or a bias of 0 stands for the default, and a negative one for none. */
const orNone = (value) => value > 0 ? value : -1;

const BEGIN = { model: 'builtin:knot', sky: 'builtin:sky' };
Object.assign(state, { worker: null, model: '', sky: '', files: new Map(), block: null, blockOf: '', early: null, stages: [], finer: false, began: false, shown: false });
const call = (name, types, ...values) => callC('pd', name, types, values);

/* ---- building ---- */

function bytesOf(base64) {
    if (Uint8Array.fromBase64) return Uint8Array.fromBase64(base64);
    const text = atob(base64), bytes = new Uint8Array(text.length);
    for (let i = 0; i < bytes.length; i++) bytes[i] = text.charCodeAt(i);
    return bytes;
}

/* The program's WebAssembly, which product.wasm.js has as text, compiled once. */
const compiled = WebAssembly.compile(bytesOf(DappleProduct.wasm));
DappleProduct.wasm = null;

/* For Emscripten's options: begins with WebAssembly that is compiled. Emscripten does not hear of a failure, such as no memory. */
function fromModule(module, fail) {
    return (imports, receive) => {
        WebAssembly.instantiate(module, imports).then((instance) => receive(instance, module)).catch(fail);
        return {};
    };
}

/* The worker's own program: it is this text, with that of product.wasm.js before it, since a page from the disk may not
   fetch scripts for workers. */
function work() {
    const told = (fraction) => { self.postMessage({ fraction }); return false; };
    const fail = (error) => self.postMessage({ error: 'building failed: ' + error.message });
    const run = async ({ name, bytes, sides, how, module }) => {
        const program = await self.DappleProduct({ onProgress: told, print: () => {}, printErr: () => {}, instantiateWasm: fromModule(module, fail) });
        const text = (f) => program.ccall(f, 'string', [], []);
        if (bytes) program.FS.writeFile(name, bytes);
        if (program.ccall('pd_load', 'number', ['string'], [name]) !== 0)
            return self.postMessage({ error: text('pd_error') });
        for (const [side, map] of sides) {
            const started = performance.now();
            self.postMessage({ stage: side });
            if (program.ccall('pd_build', 'number', Array(5).fill('number'), [side, map, ...how]) !== 0)
                return self.postMessage({ error: text('pd_error') });
            const at = program.ccall('pd_block', 'number', [], []), size = program.ccall('pd_block_bytes', 'number', [], []);
            const block = program.HEAPU8.slice(at, at + size);
            self.postMessage({ block, side, ms: performance.now() - started }, [block.buffer]);
        }
        self.postMessage({ done: true });
    };
    self.onmessage = ({ data }) => run(data).catch(fail);       // the page would not hear of a promise that fails
}

function stop() {
    if (state.worker) state.worker.terminate();
    state.worker = null;
    element('work').style.display = 'none';
}

/* How maps are built, other than their number and size. */
const manner = () => [number('layers'), number('depthbits'), number('thickness')];

/* The maps that have come with the page, or null where others are wanted. */
function made() {
    const { first } = DappleProduct;
    return first && first.model === state.model && String([SIDES[0], manner()]) === String([first.size, first.how]) ? bytesOf(first.block) : null;
}

function tell(side, block, more) {
    element('facts').textContent = `${side} x ${side} maps, ${(block.length / 1e6).toFixed(1)} MB${more}`;
}

/* Builds maps of the model, of each of these sizes; `stages` are there already. */
function build(sides = SIDES, stages = []) {
    const script = 'var _scriptDir = ""; self.DappleProduct = ' + DappleProduct.toString() + ';' + fromModule.toString()
        + ';(' + work.toString() + ')();';
    const url = URL.createObjectURL(new Blob([script], { type: 'text/javascript' }));
    stop();
    state.finer = false;
    state.stages = stages;
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
            if (state.began && !state.lost) give(data.block);
            else state.early = data.block;          // begin() takes it
            tell(data.side, data.block, `, built in ${(data.ms / 1000).toFixed(1)} s`);
        }
        if (data.done) stop();
    };
    const worker = state.worker, job = { name: state.model, bytes: state.files.get(state.model), sides: [...sides], how: manner() };
    compiled.then((module) => worker.postMessage({ ...job, module }), stop);
}

/* Other maps are asked for: coarse ones first, as always, each finer than the one before. */
function rebuild() {
    const side = number('side'), pixels = number('pixels');
    const coarse = [[16, Math.min(32, pixels)], [Math.ceil(side / 2), pixels]].filter(([s], i) => s >= 16 + i && s < side);
    SIDES.splice(0, SIDES.length, ...coarse, [side, pixels]);
    if (!state.began) return;                       // begin() builds
    if (!state.lost) say('');
    build();
}

/* Drivers compile the shaders when something is first drawn by them: a few pixels with the maps that are there and a dark sky. The
   processor makes the sky that will be seen, meanwhile. */
function warm() {
    if (!call('sky', ['string'], 'dark')) return;
    canvas.width = canvas.height = 16;
    if (call('size', ['number', 'number'], 16, 16)) draw(1, 1);
    state.context.flush();
}

/* Files that were dropped are in the list of models, and that of skies, to be taken again: the last two of each. */
function keep(list, end) {
    const names = [...state.files.keys()].filter((name) => name.toLowerCase().endsWith(end));
    for (const name of names.slice(0, -2).filter((n) => n !== state.model && n !== state.sky)) {
        state.files.delete(name);
        [...element(list).options].find((o) => o.value === name)?.remove();
    }
}

/* Gives a block of csm.h to the program as the maps of the model. */
function upload(block) {
    const at = state.program._malloc(block.length);
    let good = at !== 0;
    if (good) {
        state.program.HEAPU8.set(block, at);
        good = call('open', Array(3).fill('number'), at, block.length, number('fast'));
        state.program._free(at);
    } else say('out of memory');
    return good;
}

/* Takes a block as the maps of the model, from now on. */
function give(block) {
    if (!upload(block)) return false;
    state.block = block;
    state.blockOf = state.model;
    element('save').disabled = false;
    state.ready = state.anew = true;
    return true;
}

/* ---- models, skies, files ---- */

function read(what, name) {
    if (state.files.has(name)) state.program.FS.writeFile(name, state.files.get(name));
    const good = call(what, ['string'], name);
    if (state.files.has(name)) state.program.FS.unlink(name);
    return good;
}

/* Without the program, or a context, the name is all that can be taken: begin() does the rest. */
const waiting = () => !state.began || state.lost;

function load(name) {
    if (waiting()) {
        stop();
        Object.assign(state, { model: name, block: null, early: null });
        element('save').disabled = true;
        return true;
    }
    say('');
    const before = state.model;
    if (!read('load', name)) { state.files.delete(name); pick('model', before); return false; }
    state.model = name;
    state.ready = false;
    state.block = state.early = null;               // the maps that are there are another model's
    element('save').disabled = true;
    element('facts').textContent = `${state.program.ccall('pd_triangles', 'number', [], [])} triangles`;
    build();
    return true;
}

function loadSky(name) {
    if (waiting()) {
        state.sky = name;
        return true;
    }
    const before = state.sky;
    if (!read('sky', name)) { state.files.delete(name); pick('sky', before); return false; }
    say('');
    state.sky = name;
    state.anew = true;
    return true;
}

function pick(list, value) {
    const select = element(list);
    if (![...select.options].some((o) => o.value === value)) select.add(new Option(value.replace(/^builtin:/, ''), value));
    select.value = value;
}

/* Takes a file as the model or the sky of its name, and as the newest. One that cannot be read leaves the file that was there. */
function put(list, name, bytes, use) {
    const before = state.files.get(name);
    state.files.delete(name);
    state.files.set(name, bytes);
    if (use(name)) pick(list, name);
    else if (before) state.files.set(name, before);
}

async function take(file) {
    const name = file.name.replace(/[^A-Za-z0-9._-]/g, '_');
    let bytes;
    try {
        bytes = new Uint8Array(await file.arrayBuffer());
    } catch {                                       // a folder, or more than there is memory
        return say(`${name}: it cannot be read`);
    }
    if (/\.glb$/i.test(name)) {
        put('model', name, bytes, load);
        keep('model', '.glb');
    } else if (/\.hdr$/i.test(name)) {
        put('sky', name, bytes, loadSky);
        keep('sky', '.hdr');
    } else if (/\.csm$/i.test(name)) {
        if (waiting()) state.early = bytes;         // whether they are maps is seen then
        else say('');
        if (state.early || give(bytes)) {
            stop();
            state.finer = false;
            element('facts').textContent = `maps from ${name}, ${(bytes.length / 1e6).toFixed(1)} MB`;
        }
    } else say(`${name}: drop a .glb, a .hdr or saved maps (.csm)`);
}

/* ---- frames ---- */

function size() {
    resized();
    return call('size', ['number', 'number'], canvas.width, canvas.height);
}

function draw(samples, anew) {
    state.program.ccall('pd_ask', null, Array(4).fill('number'), [number('filter'), orNone(number('bias')), number('offset') / 100, number('sampling')]);
    return call('frame', ['number', 'number', 'number', 'number', 'number', 'number', 'number', 'number', 'number'], view.azimuth,
        view.elevation, view.distance, view.up, element('turn').value * Math.PI / 180, 2 ** element('exposure').value,
        samples, element('show').checked ? 1 : 0, anew);
}

function frame() {
    if (!state.shown) state.scale = FIRST;
    else {
        if (!state.second) state.scale = 1;
        state.second = true;
        if (state.finer) build(SIDES.slice(1), state.stages);       // the first picture has had the processors for itself
    }
    if (!size()) return;
    const frames = state.program.ccall('pd_frames', 'number', [], []);
    if (!state.anew && frames >= FULL) return;
    const anew = state.anew ? 1 : 0;
    state.anew = false;
    draw(state.shown ? 2 ** element('samples').value : FIRST_SAMPLES, anew);
    state.shown = true;
    drawn(state.program.ccall('pd_frames', 'number', [], []));
}

/* ---- what the user does ---- */

function listenToFiles() {
    for (const id of ['turn', 'exposure', 'samples', 'show', 'filter', 'bias', 'offset', 'sampling']) element(id).addEventListener('input', moved);
    for (const id of ['side', 'pixels', 'layers', 'depthbits', 'thickness']) element(id).addEventListener('change', rebuild);
    element('fast').addEventListener('change', () => { if (state.block && !state.lost) give(state.block); });
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

/* Reads a model or a sky that was chosen before the program or the context was there. One that cannot be read is left out. */
function readChosen(what, list) {
    if (read(what, state[list])) return true;
    const bad = state[list];
    if (bad === BEGIN[list]) return false;
    if (state.files.delete(bad)) [...element(list).options].find((o) => o.value === bad)?.remove();
    state[list] = BEGIN[list];
    if (what === 'load') {                          // maps of what is left out are no other model's
        stop();
        state.block = state.early = null;
    }
    pick(list, state[list]);
    return read(what, state[list]);
}

/* On a context that is new. One that comes back has nothing of ours: model, sky and maps are given to it again. The first time
   shaders are compiled before the sky is made, since a GPU does that beside us. */
function begin() {
    if (!call('start', []) || !readChosen('load', 'model')) return false;
    let block = state.early || state.block;
    state.early = null;
    if (!block && (block = made())) {
        state.finer = !state.worker && SIDES.length > 1;
        state.stages = [SIDES[0][0]];
        tell(SIDES[0][0], block, '');
    }
    const good = block !== null && give(block);
    if (!state.shown) {
        if (good || (DappleProduct.first && upload(bytesOf(DappleProduct.first.block)))) warm();
        state.scale = FIRST;
    }
    if (!size() || !readChosen('sky', 'sky')) return false;
    state.began = true;
    if (!good && !state.worker) build();
    return true;
}

for (const name of ['knot', 'plant', 'robots', 'figure']) pick('model', 'builtin:' + name);
for (const name of ['sky', 'overcast', 'studio']) pick('sky', 'builtin:' + name);
for (const list of ['model', 'sky']) element(list).value = state[list] = BEGIN[list];
listen({});
listenToFiles();
startPage({ create: async (options) => {
    const module = await compiled;
    return new Promise((good, fail) => DappleProduct({ ...options, instantiateWasm: fromModule(module, fail) }).then(good, fail));
}, begin, frame, lose() { state.program.ccall('pd_lost', null, [], []); } });
