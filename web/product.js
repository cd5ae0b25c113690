/* product.js - the page "product": what the user does, turned into calls of product.c. The maps of a model are built by a
   second copy of the program in a worker, coarse ones first, so that shadows are there at once and grow finer. */
'use strict';

const element = (id) => document.getElementById(id);
const canvas = element('picture');
const SIDES = [[16, 64], [48, 128], [96, 128]];     // maps a side of the directions, pixels a side of a map
let FULL = 64;                                      // frames in the mean, then the picture rests

const view = { azimuth: 0.9, elevation: 0.35, distance: 3.6, up: -0.1 };
const state = {
    program: null, context: null, worker: null, ready: false, lost: false,
    model: 'builtin:knot', sky: 'builtin:sky', files: new Map(), block: null, blockOf: '',
    anew: true, moved: 0, scale: 1, slow: 0, last: 0, fence: null, stages: []
};

/* ---- messages ---- */

function say(text) {
    element('message').textContent = text;
    element('message').classList.toggle('shown', text !== '');
}

/* Calls a function of product.c; a failure is shown, and the page goes on. */
function call(name, types, ...values) {
    const result = state.program.ccall(name, 'number', types, values);
    if (result !== 0) say(state.program.ccall('pd_error', 'string', [], []));
    return result === 0;
}

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

/* Takes a block of csm.h as the maps of the model. */
function give(block) {
    const at = state.program._malloc(block.length);
    let good = at !== 0;
    if (good) {
        state.program.HEAPU8.set(block, at);
        good = call('pd_open', ['number', 'number'], at, block.length);
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
    const good = call('pd_load', ['string'], name);
    if (state.files.has(name)) state.program.FS.unlink(name);
    if (!good) { state.files.delete(name); pick('model', before); return; }
    state.model = name;
    state.ready = false;
    element('save').disabled = true;
    element('facts').textContent = `${state.program.ccall('pd_triangles', 'number', [], [])} triangles`;
    build();
}

function loadSky(name) {
    const before = state.sky;
    if (state.files.has(name)) state.program.FS.writeFile(name, state.files.get(name));
    const good = call('pd_sky', ['string'], name);
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
    const width = Math.max(1, Math.round(canvas.clientWidth * state.scale)),
        height = Math.max(1, Math.round(canvas.clientHeight * state.scale));
    if (canvas.width !== width || canvas.height !== height) {
        canvas.width = width;
        canvas.height = height;
        state.anew = true;
    }
    return call('pd_size', ['number', 'number'], width, height);
}

/* Where frames take long, pixels become larger; a picture that rests gets them back. */
function adapt(now) {
    const took = now - state.last;
    state.last = now;
    const moving = now - state.moved < 300;
    if (moving) {
        state.slow = took > 120 ? state.slow + 1 : Math.max(0, state.slow - 1);
        if (state.slow > 2 && state.scale > 0.3) { state.scale *= 0.75; state.slow = 0; }
    } else if (state.scale < 1 && now - state.moved > 600) state.scale = 1;
}

/* Whether the last frame is still being drawn. Without this a slow GPU would be asked for more than it can do, and what the
   user does would show seconds later. */
function busy() {
    const gl = state.context;
    if (!state.fence) return false;
    if (gl.clientWaitSync(state.fence, 0, 0) === gl.TIMEOUT_EXPIRED) return true;
    gl.deleteSync(state.fence);
    state.fence = null;
    return false;
}

function frame(now) {
    requestAnimationFrame(frame);
    if (!state.program || state.lost || !state.ready || busy()) return;
    adapt(now);
    if (!size()) return;
    const frames = state.program.ccall('pd_frames', 'number', [], []);
    if (!state.anew && frames >= FULL) return;
    const anew = state.anew ? 1 : 0;
    state.anew = false;
    call('pd_frame', ['number', 'number', 'number', 'number', 'number', 'number', 'number', 'number', 'number'], view.azimuth,
        view.elevation, view.distance, view.up, element('turn').value * Math.PI / 180, 2 ** element('exposure').value,
        2 ** element('samples').value, element('show').checked ? 1 : 0, anew);
    state.fence = state.context.fenceSync(state.context.SYNC_GPU_COMMANDS_COMPLETE, 0);
    state.context.flush();
    window.dappleFrames = state.program.ccall('pd_frames', 'number', [], []);       // for tests
}

function moved() {
    state.anew = true;
    state.moved = performance.now();
}

/* ---- what the user does ---- */

function orbit(dx, dy) {
    view.azimuth += dx;
    view.elevation = Math.min(1.5, Math.max(-0.2, view.elevation + dy));
    moved();
}

function turn(angle) {
    let degrees = +element('turn').value + angle;
    degrees = ((degrees + 180) % 360 + 360) % 360 - 180;
    element('turn').value = degrees;
    moved();
}

function zoom(factor) {
    view.distance = Math.min(20, Math.max(1.2, view.distance * factor));
    moved();
}

function listen() {
    const pointers = new Map();
    canvas.addEventListener('pointerdown', (e) => {
        canvas.setPointerCapture(e.pointerId);
        pointers.set(e.pointerId, { x: e.clientX, y: e.clientY });
    });
    canvas.addEventListener('pointermove', (e) => {
        const p = pointers.get(e.pointerId);
        if (!p) return;
        const dx = e.clientX - p.x, dy = e.clientY - p.y, height = canvas.clientHeight;
        if (pointers.size === 2) {
            const [a, b] = [...pointers.values()], other = a === p ? b : a;
            const before = Math.hypot(p.x - other.x, p.y - other.y),
                after = Math.hypot(e.clientX - other.x, e.clientY - other.y);
            if (before > 1 && after > 1) zoom(before / after);
            turn(90 * dx / height);
        } else if (e.shiftKey || e.buttons === 2) turn(180 * dx / height);
        else orbit(3 * dx / height, 3 * dy / height);
        p.x = e.clientX;
        p.y = e.clientY;
    });
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, (e) => pointers.delete(e.pointerId));
    canvas.addEventListener('contextmenu', (e) => e.preventDefault());
    canvas.addEventListener('wheel', (e) => { e.preventDefault(); zoom(2 ** (e.deltaY / 600)); }, { passive: false });
    canvas.addEventListener('keydown', (e) => {
        const keys = { ArrowLeft: () => orbit(-0.1, 0), ArrowRight: () => orbit(0.1, 0), ArrowUp: () => orbit(0, 0.1),
            ArrowDown: () => orbit(0, -0.1), a: () => turn(-5), d: () => turn(5), '+': () => zoom(0.9), '-': () => zoom(1.1) };
        if (!keys[e.key]) return;
        keys[e.key]();
        e.preventDefault();
    });
    for (const id of ['turn', 'exposure', 'samples', 'show']) element(id).addEventListener('input', moved);
    element('model').addEventListener('change', () => load(element('model').value));
    element('sky').addEventListener('change', () => loadSky(element('sky').value));
    element('open').addEventListener('change', (e) => { for (const file of e.target.files) take(file); e.target.value = ''; });
    element('cancel').addEventListener('click', stop);
    element('save').addEventListener('click', save);
    element('fold').addEventListener('click', fold);
    document.addEventListener('dragover', (e) => { e.preventDefault(); element('stage').classList.add('over'); });
    document.addEventListener('dragleave', () => element('stage').classList.remove('over'));
    document.addEventListener('drop', async (e) => {
        e.preventDefault();
        element('stage').classList.remove('over');
        for (const file of e.dataTransfer.files) await take(file);
    });
}

function fold() {
    const closed = element('panel').classList.toggle('closed');
    element('fold').textContent = closed ? 'show' : 'hide';
    element('fold').setAttribute('aria-expanded', String(!closed));
}

function save() {
    const link = document.createElement('a');
    link.href = URL.createObjectURL(new Blob([state.block]));
    link.download = state.blockOf.replace(/^builtin:/, '').replace(/\.glb$/i, '') + '.csm';
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/* ---- start ---- */

function startGL() {
    const handle = state.program.GL.registerContext(state.context, { majorVersion: 2, minorVersion: 0 });
    state.program.GL.makeContextCurrent(handle);
    return call('pd_start', []);
}

/* A context that comes back has nothing of ours: model, sky and maps are given to it again. */
function survive() {
    canvas.addEventListener('webglcontextlost', (e) => {
        e.preventDefault();
        state.lost = true;
        state.fence = null;
        say('The browser took the picture\'s memory away; it comes back when the browser gives it back.');
        state.program.ccall('pd_lost', null, [], []);
    });
    canvas.addEventListener('webglcontextrestored', () => {
        const files = state.files, put = (name) => { if (files.has(name)) state.program.FS.writeFile(name, files.get(name)); };
        say('');
        put(state.model);
        put(state.sky);
        const good = startGL() && size() && call('pd_sky', ['string'], state.sky) && call('pd_load', ['string'], state.model);
        state.lost = false;
        if (good && state.block) give(state.block);
    });
}

async function start() {
    state.context = canvas.getContext('webgl2', { antialias: false, alpha: false, powerPreference: 'high-performance' });
    if (!state.context) {
        element('stage').style.display = element('panel').style.display = 'none';
        element('instead').style.display = 'block';
        element('reason').textContent = 'Chrome 56, Firefox 51, Safari 15 and later have it.';
        return;
    }
    state.program = await DappleProduct({ print: () => {}, printErr: (text) => console.warn(text) });
    for (const name of ['knot', 'plant', 'robots', 'figure']) pick('model', 'builtin:' + name);
    for (const name of ['sky', 'overcast', 'studio']) pick('sky', 'builtin:' + name);
    element('model').value = state.model;
    element('sky').value = state.sky;
    listen();
    survive();
    if (startGL() && size() && call('pd_sky', ['string'], state.sky)) load(state.model);
    requestAnimationFrame(frame);
}

start();
