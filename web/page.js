/* page.js - what all pages have in common: messages, the context, its loss and its absence, the size of the picture, which
   falls where frames take long, the camera by pointer, touch and keys. Each page calls startPage() with what is its own. */
'use strict';

const element = (id) => document.getElementById(id);
const canvas = element('picture');
let FULL = 64;                                      // frames in the mean, then the picture rests

const view = { azimuth: 0.9, elevation: 0.35, distance: 3.6, up: -0.1 };
const limits = { azimuth: [-Infinity, Infinity], elevation: [-0.2, 1.5], distance: [1.2, 20] };
const state = { program: null, context: null, ready: false, lost: false, anew: true, moved: 0, scale: 1, slow: 0, last: 0, fence: null, asked: 0 };

/* ---- messages ---- */

function say(text) {
    element('message').textContent = text;
    element('message').classList.toggle('shown', text !== '');
}

/* The page's functions in C are called `prefix`_NAME. A failure is shown, and the page goes on. */
function callC(prefix, name, types, values) {
    const result = state.program.ccall(`${prefix}_${name}`, 'number', types, values);
    if (result !== 0) say(state.program.ccall(`${prefix}_error`, 'string', [], []));
    return result === 0;
}

/* ---- frames ---- */

/* The size that the picture should have now; true if it is another one. */
function resized() {
    const width = Math.max(1, Math.round(canvas.clientWidth * state.scale)),
        height = Math.max(1, Math.round(canvas.clientHeight * state.scale));
    if (canvas.width === width && canvas.height === height) return false;
    canvas.width = width;
    canvas.height = height;
    state.anew = true;
    return true;
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
    window.dappleCost = performance.now() - state.asked;
    return false;
}

function drawn(frames) {
    state.fence = state.context.fenceSync(state.context.SYNC_GPU_COMMANDS_COMPLETE, 0);
    state.asked = performance.now();
    state.context.flush();
    window.dappleFrames = frames;                   // for tests
}

function moved() {
    state.anew = true;
    state.moved = performance.now();
}

/* ---- what the user does ---- */

const within = (x, [low, high]) => Math.min(high, Math.max(low, x));

function orbit(dx, dy) {
    view.azimuth = within(view.azimuth + dx, limits.azimuth);
    view.elevation = within(view.elevation + dy, limits.elevation);
    moved();
}

function zoom(factor) {
    view.distance = within(view.distance * factor, limits.distance);
    moved();
}

/* Turns the slider "turn", in degrees, if the page has one. */
function turn(angle) {
    const slider = element('turn');
    if (!slider) return;
    slider.value = ((+slider.value + angle + 180) % 360 + 360) % 360 - 180;
    slider.show();
    moved();
}

/* Each slider says its number. */
function showNumbers() {
    for (const slider of document.querySelectorAll('#panel input[type=range]')) {
        const shown = document.createElement('output');
        const show = () => {
            const value = slider.dataset.power ? 2 ** slider.value : +slider.value;
            shown.textContent = String(+value.toPrecision(3));
        };
        slider.after(shown);
        slider.addEventListener('input', show);
        slider.show = show;
        show();
    }
}

/* grab: { press(x, y), drag(x, y), release() } of things in the picture, x and y -1..1; or none. keys: more of them. */
function listen({ grab = null, keys = {} }) {
    showNumbers();
    const pointers = new Map();
    const place = (e) => [2 * e.offsetX / canvas.clientWidth - 1, 1 - 2 * e.offsetY / canvas.clientHeight];
    let held = null;
    canvas.addEventListener('pointerdown', (e) => {
        canvas.setPointerCapture(e.pointerId);
        pointers.set(e.pointerId, { x: e.clientX, y: e.clientY });
        if (grab && pointers.size === 1 && e.buttons === 1 && !e.shiftKey && grab.press(...place(e))) held = e.pointerId;
    });
    canvas.addEventListener('pointermove', (e) => {
        const p = pointers.get(e.pointerId);
        if (!p) return;
        const dx = e.clientX - p.x, dy = e.clientY - p.y, height = canvas.clientHeight;
        if (e.pointerId === held) {
            grab.drag(...place(e));
            moved();
        } else if (pointers.size === 2) {
            const [a, b] = [...pointers.values()], other = a === p ? b : a;
            const before = Math.hypot(p.x - other.x, p.y - other.y), after = Math.hypot(e.clientX - other.x, e.clientY - other.y);
            if (before > 1 && after > 1) zoom(before / after);
            turn(90 * dx / height);
        } else if (e.shiftKey || e.buttons === 2) turn(180 * dx / height);
        else orbit(3 * dx / height, 3 * dy / height);
        p.x = e.clientX;
        p.y = e.clientY;
    });
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, (e) => {
        pointers.delete(e.pointerId);
        if (e.pointerId === held) { held = null; grab.release(); }
    });
    canvas.addEventListener('contextmenu', (e) => e.preventDefault());
    canvas.addEventListener('wheel', (e) => {
        if (document.documentElement.classList.contains('here') && !e.ctrlKey) return;     // the index is scrolled by it
        e.preventDefault();
        zoom(2 ** (e.deltaY / 600));
    }, { passive: false });
    canvas.addEventListener('keydown', (e) => {
        const all = { ArrowLeft: () => orbit(-0.1, 0), ArrowRight: () => orbit(0.1, 0), ArrowUp: () => orbit(0, 0.1),
            ArrowDown: () => orbit(0, -0.1), a: () => turn(-5), d: () => turn(5), '+': () => zoom(0.9), '-': () => zoom(1.1), ...keys };
        if (e.ctrlKey || e.altKey || e.metaKey || !all[e.key]) return;      // the browser's own, as Ctrl and + are
        all[e.key]();
        e.preventDefault();
    });
    element('fold').addEventListener('click', () => {
        const closed = element('panel').classList.toggle('closed');
        element('fold').textContent = closed ? 'show' : 'hide';
        element('fold').setAttribute('aria-expanded', String(!closed));
    });
}

/* ---- start ---- */

/* create: makes the program. begin(): gives everything to a context that is new, and says whether that worked. lose(): the
   context is gone. frame(now): draws if there is something to draw. */
async function startPage({ create, begin, lose, frame }) {
    state.context = canvas.getContext('webgl2', { antialias: false, alpha: false, powerPreference: 'high-performance' });
    if (!state.context) {
        element('stage').style.display = element('panel').style.display = 'none';
        element('instead').style.display = 'block';
        element('reason').textContent = 'Chrome 56, Firefox 51, Safari 15 and later have it.';
        return;
    }
    const adopt = () => {
        const handle = state.program.GL.registerContext(state.context, { majorVersion: 2, minorVersion: 0 });
        state.program.GL.makeContextCurrent(handle);
        return begin();
    };
    /* A context may be lost, and come back, before the program is there. */
    canvas.addEventListener('webglcontextlost', (e) => {
        e.preventDefault();
        state.lost = true;
        state.fence = null;
        say('The browser took the picture\'s memory away; it comes back when the browser gives it back.');
        if (state.program) lose();
    });
    canvas.addEventListener('webglcontextrestored', () => {
        say('');
        if (state.program) adopt();
        state.lost = false;
        state.anew = true;
    });
    try {
        state.program = await create({ print: () => {}, printErr: (text) => console.warn(text) });
    } catch (error) {
        say(`The page cannot begin: ${error.message}`);
        return;
    }
    if (!state.lost) adopt();
    const loop = (now) => {
        requestAnimationFrame(loop);
        if (state.lost || !state.ready || busy()) return;
        adapt(now);
        frame(now);
    };
    requestAnimationFrame(loop);
}
