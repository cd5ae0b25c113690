/* scene.js - the pages room, game, sky and filter: their knobs, which are the elements with data-knob and its number, what is dragged,
   and time. page.c has what is called. */
'use strict';

const knobs = [...document.querySelectorAll('[data-knob]')];
const clock = { time: 0.5, last: 0 };
const call = (name, types, ...values) => callC('pg', name, types, values);
const ask = (name, ...values) => state.program.ccall(`pg_${name}`, 'number', values.map(() => 'number'), values);
const KNOBS = 20;                                    // PG_KNOBS of stage.h
let knobsAt = 0;

function readKnobs() {
    const out = state.program.HEAPF32;
    for (const knob of knobs) {
        const text = knob.dataset.late ? knob.dataset.set ?? knob.value : knob.value;
        const value = knob.type === 'checkbox' ? (knob.checked ? 1 : 0) : +text;
        out[knobsAt / 4 + +knob.dataset.knob] = knob.dataset.power ? 2 ** value : value;
    }
}

/* Steps of time are as long as frames take, a fifth of a second at most. */
function tick(now) {
    const play = element('play');
    if (play && play.checked) {
        clock.time += Math.min(0.2, (now - clock.last) / 1000);
        state.anew = true;
        state.moved = now;
    }
    clock.last = now;
}

function frame(now) {
    tick(now);
    resized();
    if (!call('size', ['number', 'number'], canvas.width, canvas.height)) return;
    if (!state.anew && ask('frames') >= FULL) return;
    const anew = state.anew ? 1 : 0;
    state.anew = false;
    readKnobs();
    const good = call('frame', ['number', 'number', 'number', 'number', 'number', 'number', 'number'], view.azimuth, view.elevation,
        view.distance, view.up, knobsAt, clock.time, anew);
    if (!good) state.ready = false;                  // the message stays until a knob is moved
    drawn(ask('frames'));
}

/* x, y, z of something that can be dragged, and where it is in the window, -1..1. */
function handleAt(i) {
    const at = ask('handle_at', i);
    return at ? [...state.program.HEAPF32.subarray(at / 4, at / 4 + 5)] : null;
}

const SCENES = {
    room: { create: () => DappleRoom, view: { azimuth: 1.5708, elevation: 0.12, distance: 1.9, up: 0.02 },
        limits: { azimuth: [0.95, 2.2], elevation: [-0.1, 0.6], distance: [1, 4] } },        // it has no front wall
    game: { create: () => DappleGame, view: { azimuth: 1.1, elevation: 0.75, distance: 1.9, up: 0.22 }, limits: { elevation: [0.05, 1.5] } },
    sky: { create: () => DappleSky, view: { azimuth: 1.2, elevation: 0.22, distance: 2.5, up: -0.1 }, limits: { elevation: [0, 1.5] } },
    filter: { create: () => DappleFilter, view: { azimuth: -1.5708, elevation: 0, distance: 2.35, up: 0 },
        limits: { azimuth: [-2.2, -0.95], elevation: [-0.3, 0.5], distance: [1, 4] } }
};

/* Of the page filter: a frame more, and its error, in hundredths of the light's mean. */
function measure() {
    if (!state.ready || state.lost) return;
    const at = ask('filter_measure') / 4, [noisy, smooth] = state.program.HEAPF32.subarray(at, at + 2);
    element('facts').textContent = smooth < 0 ? 'it could not be measured'
        : `off by ${(100 * noisy).toPrecision(2)} % of the light as gathered, ${(100 * smooth).toPrecision(2)} % made smooth`;
    window.dappleMeasured = [noisy, smooth];
    moved();
}

function start(own) {
    Object.assign(view, own.view);
    Object.assign(limits, own.limits);
    for (const [name, value] of new URLSearchParams(location.hash.slice(1))) {
        const knob = /^knob\d+$/.test(name) && document.querySelector(`[data-knob="${name.slice(4)}"]`);
        if (knob) {                                  // as its slider has it; a box is checked by 1
            knob.value = value;
            knob.checked = value === '1';
        }
        if (name === 'still') {                      // nothing moves, and so many frames: for pictures
            FULL = +value;
            if (element('play')) element('play').checked = false;
        }
    }
    let begun = false;
    const turned = () => {                           // what a knob has broken, such as maps that are too large, another value mends
        if (begun && !state.ready && !state.lost) {
            say('');
            state.ready = true;
        }
        moved();
    };
    for (const knob of knobs) {
        if (knob.dataset.late) {                     // what takes long is built when the slider is let go
            knob.dataset.set = knob.value;
            knob.addEventListener('change', () => { knob.dataset.set = knob.value; turned(); });
        } else knob.addEventListener('input', turned);
    }
    if (element('measure')) element('measure').addEventListener('click', measure);
    const grab = { press: (x, y) => state.program && ask('press', x, y), drag: (x, y) => state.program.ccall('pg_drag', null, ['number', 'number'], [x, y]),
        release: () => state.program.ccall('pg_release', null, [], []) };
    listen({ grab });
    startPage({
        create: own.create(), frame,
        begin() {
            if (!knobsAt) knobsAt = state.program._malloc(4 * KNOBS);
            resized();
            state.ready = call('start', []) && call('size', ['number', 'number'], canvas.width, canvas.height);
            return begun = state.ready;
        },
        lose() { state.program.ccall('pg_lost', null, [], []); }
    });
}

start(SCENES[document.body.dataset.page]);
