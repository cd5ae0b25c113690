/* pages.mjs - the pages that web/make has written, in Chromium on its software renderer, and some in Firefox on Mesa's, driven
   by puppeteer-core: node pages.mjs FOLDER NATIVE SCRATCH. NATIVE is the program of native.c; beside it lie those of
   native_scene.c, their names ended by _room, _game, _sky and _filter. Prints as cmocka does, for tools/run-tests. ONLY in the
   environment is a regular expression of the tests' names. LONG=1: room and chess lose their contexts, too, a minute more. */
import puppeteer from 'puppeteer-core';
import { execFileSync } from 'node:child_process';
import { copyFileSync, existsSync, readdirSync, readFileSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { deflateSync, gzipSync, inflateSync } from 'node:zlib';
import { resolve } from 'node:path';

const [folder, native, scratch] = process.argv.slice(2).map((p) => resolve(p));
const WIDTH = 256, HEIGHT = 144;
let browser, page, said, lost;

const wait = (ms) => new Promise((done) => setTimeout(done, ms));
function must(truth, text) { if (!truth) throw new Error(text); }

/* ---- files ---- */

/* A .glb of boxes, each [x0, y0, z0, x1, y1, z1]. */
function boxes(...list) {
    const positions = [], indices = [];
    for (const b of list) {
        const at = positions.length / 3;
        for (let i = 0; i < 8; i++) positions.push(b[i & 1 ? 3 : 0], b[i & 2 ? 4 : 1], b[i & 4 ? 5 : 2]);
        for (const q of [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])
            indices.push(at + q[0], at + q[1], at + q[2], at + q[0], at + q[2], at + q[3]);
    }
    const p = Buffer.from(new Float32Array(positions).buffer), n = Buffer.from(new Uint32Array(indices).buffer);
    const low = [0, 1, 2].map((k) => Math.min(...positions.filter((_, i) => i % 3 === k)));
    const high = [0, 1, 2].map((k) => Math.max(...positions.filter((_, i) => i % 3 === k)));
    return glb(JSON.stringify({
        asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
        meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
        buffers: [{ byteLength: p.length + n.length }],
        bufferViews: [{ buffer: 0, byteOffset: 0, byteLength: p.length }, { buffer: 0, byteOffset: p.length, byteLength: n.length }],
        accessors: [{ bufferView: 0, componentType: 5126, count: positions.length / 3, type: 'VEC3', min: low, max: high },
            { bufferView: 1, componentType: 5125, count: indices.length, type: 'SCALAR' }]
    }), Buffer.concat([p, n]));
}

function glb(json, binary) {
    const text = Buffer.from(json.padEnd(Math.ceil(json.length / 4) * 4, ' '));
    const head = Buffer.alloc(20), middle = Buffer.alloc(8);
    head.write('glTF', 0);
    head.writeUInt32LE(2, 4);
    head.writeUInt32LE(28 + text.length + binary.length, 8);
    head.writeUInt32LE(text.length, 12);
    head.write('JSON', 16);
    middle.writeUInt32LE(binary.length, 0);
    middle.write('BIN\0', 4);
    return Buffer.concat([head, text, middle, binary]);
}

/* A .png of one pixel. */
function onePixel(...rgb) {
    const part = (kind, body) => {
        const out = Buffer.alloc(12 + body.length), named = Buffer.concat([Buffer.from(kind, 'latin1'), body]);
        out.writeUInt32BE(body.length, 0);
        named.copy(out, 4);
        out.writeUInt32BE(crc(named), 8 + body.length);
        return out;
    };
    const head = Buffer.from([0, 0, 0, 1, 0, 0, 0, 1, 8, 2, 0, 0, 0]);
    return Buffer.concat([Buffer.from('\x89PNG\r\n\x1a\n', 'latin1'), part('IHDR', head), part('IDAT', deflateSync(Buffer.from([0, ...rgb]))),
        part('IEND', Buffer.alloc(0))]);
}

function crc(bytes) {
    let sum = 0xffffffff;
    for (const b of bytes) {
        sum ^= b;
        for (let k = 0; k < 8; k++) sum = sum & 1 ? (sum >>> 1) ^ 0xedb88320 : sum >>> 1;
    }
    return (sum ^ 0xffffffff) >>> 0;
}

/* A .glb of a plate, 2 x 2, on a foot that is 0.4 high, whose normal map has one normal, x, y, z along +X, -Z and up. Or x, y, z
   are a texel, 0..1, of its map of roughness and metal. */
function plate(x, y, z, rough = false) {
    const f = (...list) => Buffer.from(new Float32Array(list).buffer);
    const picture = onePixel(...[x, y, z].map((v) => Math.round(rough ? 255 * v : 127.5 + 127.5 * v)));
    const material = rough ? { pbrMetallicRoughness: { metallicRoughnessTexture: { index: 0 } } }
        : { normalTexture: { index: 0 }, pbrMetallicRoughness: { metallicFactor: 0, roughnessFactor: 1 } };
    const p = f(-1, 0.4, 1, 1, 0.4, 1, 1, 0.4, -1, -1, 0.4, -1, -0.1, 0, 0, 0.1, 0, 0, 0, 0.4, 0);
    const t = f(0, 1, 1, 1, 1, 0, 0, 0, 0, 0, 1, 0, 0, 1);
    const n = Buffer.from(new Uint32Array([0, 1, 2, 0, 2, 3, 4, 5, 6]).buffer), all = Buffer.concat([p, t, n, picture, Buffer.alloc(3)]);
    const views = [[0, p.length], [84, t.length], [140, n.length], [176, picture.length]];
    return glb(JSON.stringify({
        asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
        meshes: [{ primitives: [{ attributes: { POSITION: 0, TEXCOORD_0: 1 }, indices: 2, material: 0 }] }],
        materials: [material],
        textures: [{ source: 0 }], images: [{ bufferView: 3, mimeType: 'image/png' }], buffers: [{ byteLength: all.length & ~3 }],
        bufferViews: views.map(([byteOffset, byteLength]) => ({ buffer: 0, byteOffset, byteLength })),
        accessors: [{ bufferView: 0, componentType: 5126, count: 7, type: 'VEC3', min: [-1, 0, -1], max: [1, 0.4, 1] },
            { bufferView: 1, componentType: 5126, count: 7, type: 'VEC2' }, { bufferView: 2, componentType: 5125, count: 9, type: 'SCALAR' }]
    }), all.subarray(0, all.length & ~3));
}

/* A .hdr of 64 x 32 texels: dim everywhere, and a small sun towards +X, 45 degrees high. */
function sunnySky() {
    const out = [Buffer.from('#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 32 +X 64\n')];
    for (let y = 0; y < 32; y++)
        for (let x = 0; x < 64; x++) {
            const sun = (x === 31 || x === 32) && (y === 7 || y === 8);
            out.push(Buffer.from(sun ? [200, 190, 170, 136] : [128, 140, 160, 126]));
        }
    return Buffer.concat(out);
}

/* Pixels of a PNG as Chromium and our programs write them: 8 bits, RGB or RGBA. */
function png(data) {
    const parts = [];
    let at = 8, width, height, channels;
    while (at < data.length) {
        const length = data.readUInt32BE(at), kind = data.toString('latin1', at + 4, at + 8), body = data.subarray(at + 8, at + 8 + length);
        if (kind === 'IHDR') { width = body.readUInt32BE(0); height = body.readUInt32BE(4); channels = body[9] === 6 ? 4 : 3; }
        if (kind === 'IDAT') parts.push(body);
        at += 12 + length;
    }
    const raw = inflateSync(Buffer.concat(parts)), row = width * channels, pixels = Buffer.alloc(row * height);
    for (let y = 0; y < height; y++)
        for (let x = 0; x < row; x++) {
            const filter = raw[y * (row + 1)], left = x >= channels ? pixels[y * row + x - channels] : 0;
            const up = y ? pixels[(y - 1) * row + x] : 0, corner = y && x >= channels ? pixels[(y - 1) * row + x - channels] : 0;
            const p = left + up - corner, a = Math.abs(p - left), b = Math.abs(p - up), c = Math.abs(p - corner);
            const guess = [0, left, up, (left + up) >> 1, a <= b && a <= c ? left : b <= c ? up : corner][filter];
            pixels[y * row + x] = raw[y * (row + 1) + 1 + x] + guess;
        }
    return { width, height, at: (x, y) => [...pixels.subarray(y * row + x * channels, y * row + x * channels + 3)] };
}

/* ---- the page ---- */

const browsers = {
    chromium: { executablePath: process.env.CHROMIUM || '/usr/bin/chromium', headless: true, protocolTimeout: 240000,
        args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-dev-shm-usage', '--disable-gpu-watchdog'] },
    /* As in browsers.mjs: on Mesa's renderer, which wants a display. */
    firefox: { browser: 'firefox', executablePath: process.env.FIREFOX || '/usr/bin/firefox-esr', headless: false, protocolTimeout: 240000,
        extraPrefsFirefox: { 'webgl.force-enabled': true, 'gfx.webrender.software': true, 'webgl.out-of-process': false } }
};
let wanted = 'chromium', started = '';

/* A page of the browser that is wanted, which is started if it is not there. `lost` is set where the page or the browser dies. */
async function newPage() {
    if (browser && started !== wanted) await closeBrowser();
    if (!browser) {
        const made = await puppeteer.launch(browsers[wanted]);
        browser = made;
        started = wanted;
        made.on('disconnected', () => { if (browser === made) lost = 'the browser ended'; });
    }
    const made = await browser.newPage();
    made.on('error', (e) => { lost = `the page died: ${e.message}`; });
    return made;
}

async function closeBrowser() {
    const last = browser;
    browser = page = lost = undefined;
    await last?.close().catch(() => {});
}

/* early: a program that the page runs before its own. */
async function open(name, from = `file://${folder}`, part = 1, early = '') {
    if (page) await page.close();
    page = await newPage();
    if (early) await page.evaluateOnNewDocument(early);
    await page.setViewport({ width: part * WIDTH, height: part * HEIGHT });
    said = [];
    page.on('console', (m) => said.push(m.text()));
    page.on('pageerror', (e) => said.push(e.message));
    page.on('request', (r) => { if (!/^(file:|data:|blob:|http:\/\/127\.0\.0\.1:)/.test(r.url())) said.push(`it asks for ${r.url()}`); });
    await page.goto(`${from}/${name}`);
}

async function until(what, limit = 300000) {
    for (const end = Date.now() + limit; Date.now() < end; await wait(20)) if (await page.evaluate(what)) return;
    throw new Error(`not within ${limit / 1000} s: ${what}`);
}

const message = () => page.evaluate('document.getElementById("message").textContent');
const built = () => until('state.ready && !state.worker');
/* The picture is that of now, with so many frames in its mean. */
const settled = (frames) => until(`!state.anew && window.dappleFrames >= ${frames} && !busy()`);
const changed = () => page.evaluate('moved(), window.dappleFrames = 0');

/* Gives a file as if it had been dropped. */
async function drop(name, bytes) {
    await page.evaluate(async (file, text) => {
        const binary = atob(text), array = new Uint8Array(binary.length);
        for (let i = 0; i < array.length; i++) array[i] = binary.charCodeAt(i);
        await take(new File([array], file));
    }, name, bytes.toString('base64'));
}

async function picture() {
    /* Without the panel, and without the rim that shows where keys go. */
    await page.evaluate('document.activeElement.blur(), document.getElementById("panel").style.display = "none"');
    const image = png(Buffer.from(await (await page.$('#picture')).screenshot({ captureBeyondViewport: false })));
    await page.evaluate('document.getElementById("panel").style.display = ""');
    return image;
}

/* What a native twin draws, or, with so many paths a pixel, its path tracer. */
const twinned = new Map();
function twin(program, values, paths = 0) {
    const key = JSON.stringify([program, values, paths]);
    if (twinned.has(key)) return twinned.get(key);
    const before = reaped();
    try {
        execFileSync(program, values.map(String), { env: paths ? { ...process.env, EXACT: String(paths) } : process.env, stdio: 'pipe' });
    } catch (error) {
        if (process.env.CI || !/needs Embree/.test(error.stderr)) throw error;
        console.log(`skip: ${error.stderr}`);
        return null;
    }
    twins += reaped() - before;
    twinned.set(key, png(readFileSync(`${scratch}/native.png`)));
    return twinned.get(key);
}

/* Of two pictures of the same size: mean difference, and the share of pixels that differ by more than 8 of 255. */
function difference(shown, ours) {
    const pixels = ours.width * ours.height;
    let sum = 0, far = 0;
    for (let y = 0; y < ours.height; y++)
        for (let x = 0; x < ours.width; x++) {
            const a = ours.at(x, y), b = shown.at(x, y), d = Math.max(...a.map((v, k) => Math.abs(v - b[k])));
            sum += d;
            far += d > 8;
        }
    return { mean: sum / pixels, far: far / pixels };
}

/* A picture of a smaller size, whose pixels are the mean light of those that they stand for. */
function shrunk(image, width) {
    const n = image.width / width, light = (v) => (v / 255) ** 2.2;
    return { width, height: image.height / n, at: (x, y) => {
        const sum = [0, 0, 0];
        for (let i = 0; i < n * n; i++) image.at(x * n + i % n, y * n + Math.floor(i / n)).forEach((v, k) => { sum[k] += light(v) / n / n; });
        return sum.map((v) => 255 * v ** (1 / 2.2));
    } };
}

/* Pictures of pages as they begin, by the tests that drew them first: { shown, program, values(width, height) }. */
const drawn = {};

/* A page with a scene, still, and its picture, the mean of so many frames, which is that of the native twin within bounds. */
async function scene(name, most, [frames, part] = LOOKED_AT[wanted][name]) {
    await open(`${name}.html#still=${frames}`, undefined, part);
    await until('state.ready || document.getElementById("message").textContent !== ""');
    must(await message() === '', `it says: ${await message()}`);
    await settled(frames);
    const values = await page.evaluate('[clock.time, view.azimuth, view.elevation, view.distance, view.up]');
    const set = await page.evaluate('readKnobs(), [...state.program.HEAPF32.subarray(knobsAt / 4, knobsAt / 4 + KNOBS)]');
    const shown = await picture(), program = `${native}_${name}`;
    const all = (width, height) => [width, height, frames, ...values, `${scratch}/native.png`, ...set];
    if (wanted === 'chromium') drawn[name] = { shown, program, values: all, set };
    const d = difference(shown, twin(program, all(shown.width, shown.height)));
    console.log(`${name}: mean difference ${d.mean.toFixed(3)}, beyond 8: ${(100 * d.far).toFixed(2)} %`);
    must(d.mean < most.mean && d.far < most.far, `mean difference ${d.mean}, share of pixels beyond 8 ${d.far}`);
    must(said.length === 0, `the console has: ${said.join(' | ')}`);
    return shown;
}

/* Frames in the mean, and the part of the window, in Chromium and in Firefox, where pictures are beside the native ones alone. */
const LOOKED_AT = { chromium: { room: [4, 1], game: [4, 1], sky: [4, 1], filter: [4, 0.5] }, firefox: { room: [2, 0.5], game: [1, 0.5], sky: [4, 1], filter: [4, 0.5] } };

/* Of the page filter, pictures of the noise alone and of the smooth light alone, as they begin. */
async function halves() {
    for (const [what, line] of [['noisy', 1], ['shown', 0]]) {
        await page.evaluate(`document.querySelector('[data-knob="0"]').value = ${line}, ask('filter_again'), window.dappleFrames = 0, moved()`);
        await settled(4);
        drawn.filter[what] = await picture();
        drawn.filter.set[0] = line;
    }
}

/* Mean brightness of 5 x 5 pixels about a point of the window, -1..1. */
function at(image, [x, y]) {
    const u = Math.round((0.5 + 0.5 * x) * image.width), v = Math.round((0.5 - 0.5 * y) * image.height);
    let sum = 0;
    for (let j = -2; j <= 2; j++) for (let i = -2; i <= 2; i++) sum += image.at(u + i, v + j).reduce((a, b) => a + b) / 75;
    return sum;
}

/* Drags what lies at a point of the window, -1..1, to another, by mouse or by a finger; so many frames show it. */
async function drag(from, to, finger = false, frames = 2) {
    const { width, height } = page.viewport(), pixel = ([x, y]) => [(0.5 + 0.5 * x) * width, (0.5 - 0.5 * y) * height];
    await page.evaluate('document.getElementById("panel").style.display = "none"');
    if (finger) await touch([pixel(from), pixel(to)]);
    else {
        await page.mouse.move(...pixel(from));
        await page.mouse.down();
        await page.mouse.move(...pixel(to));
        await page.mouse.up();
    }
    await page.evaluate('window.dappleFrames = 0, moved()');
    await settled(frames);
}

/* Moves each control of the page to another value, one after the other, each with what is needed for it to matter: a frame of
   them, small, is another picture, and with the same values it is the same. steps: [[its name, value, ...], ...]; names are
   those of data-knob, or ids. All controls of the page have their step, but for those of `others`. */
async function each_control_matters(steps, others, redraw = 'undefined', frames = 1) {
    await page.setViewport({ width: WIDTH / 4, height: HEIGHT / 4 });
    await page.evaluate(`FULL = ${frames}, adapt = () => {}, document.querySelectorAll("details").forEach((d) => { d.open = true; })`);
    const has = await page.evaluate('[...document.querySelectorAll("#panel input, #panel select")].map((c) => c.dataset.knob ?? c.id)');
    const named = steps.map(([name]) => name), missing = has.filter((name) => !named.includes(name) && !others.includes(name));
    must(missing.length === 0, `no step moves ${missing}`);
    const draw = async () => {
        await page.evaluate(`${redraw}, moved(), window.dappleFrames = 0`);
        await until('!state.worker && state.ready || document.getElementById("message").textContent !== ""');
        await settled(frames);
        return picture();
    };
    let before = await draw();
    must(difference(await draw(), before).mean === 0, 'the same values give another picture');
    for (const [name, value, same = false] of steps) {
        const moves = await page.evaluate((n, v) => {
            const control = document.querySelector(`[data-knob="${n}"]`) ?? element(n), had = control.value;
            if (control.type === 'checkbox') control.checked = !control.checked;
            else control.value = v;
            for (const kind of ['input', 'change']) control.dispatchEvent(new Event(kind));
            return control.type === 'checkbox' || control.value !== had;
        }, name, value);
        must(moves, `${name} is at ${value} already, or cannot be: this step moves nothing`);
        const after = await draw(), off = difference(after, before);
        must(await message() === '', `with ${name} at ${value} it says: ${await message()}`);
        if (same) must(off.mean === 0, `${name} at ${value} changes the picture by ${off.mean}`);
        else must(off.mean > 0, `${name} at ${value} changes nothing`);
        before = after;
    }
    must(said.length === 0, `the console has: ${said.join(' | ')}`);
}

/* A page that is there loses its context and gets it back; the mean of so many frames is the picture that it was. */
async function survives(frames, most) {
    await changed();
    await settled(frames);
    const before = await picture();
    await page.evaluate('window.loser = state.context.getExtension("WEBGL_lose_context"), loser.loseContext()');
    await until('state.lost');
    must(await message() !== '', 'a lost context is not spoken of');
    await page.evaluate('window.dappleFrames = 0, loser.restoreContext()');
    await until('!state.lost && state.ready');
    await changed();
    await settled(frames);
    const off = difference(await picture(), before).mean;
    must(off < most, `after a lost context the picture differs by ${off}`);
    must(await message() === '', `it says: ${await message()}`);
}

/* Fingers on the picture, each along its own path of as many places, in pixels, step by step. */
async function touch(...paths) {
    await page.evaluate('document.getElementById("panel").style.display = "none"');
    const client = await page.createCDPSession();       // puppeteer's own touchscreen has one finger at a time
    const points = (step) => paths.map((path, id) => ({ x: path[step][0], y: path[step][1], id }));
    const tell = (type, touchPoints) => client.send('Input.dispatchTouchEvent', { type, touchPoints });
    for (let n = 1; n <= paths.length; n++) await tell('touchStart', points(0).slice(0, n));
    for (let step = 1; step < paths[0].length; step++) await tell('touchMove', points(step));
    await tell('touchEnd', []);
    await client.detach();
    await page.evaluate('document.getElementById("panel").style.display = ""');
}

/* Mean brightness of 9 x 9 pixels about the point of the picture that shows a point of the world. */
async function brightness(image, point) {
    const at = await page.evaluate((p) => {
        const c = [0, 0, 0], radius = test.radius;
        for (let k = 0; k < 3; k++) c[k] = test.center[k];
        c[1] += view.up * radius;
        const co = Math.cos(view.elevation), d = view.distance * radius;
        const f = [-co * Math.cos(view.azimuth), -Math.sin(view.elevation), -co * Math.sin(view.azimuth)];
        const eye = c.map((v, k) => v - d * f[k]), length = Math.hypot(f[0], f[2]);
        const r = [-f[2] / length, 0, f[0] / length];
        const u = [r[1] * f[2] - r[2] * f[1], r[2] * f[0] - r[0] * f[2], r[0] * f[1] - r[1] * f[0]];
        const v = p.map((x, k) => x - eye[k]), dot = (a) => a[0] * v[0] + a[1] * v[1] + a[2] * v[2];
        const top = Math.tan(0.3) * dot(f);
        return [0.5 + 0.5 * dot(r) / (top * canvas.width / canvas.height), 0.5 - 0.5 * dot(u) / top];
    }, point);
    const x = Math.round(at[0] * image.width), y = Math.round(at[1] * image.height);
    let sum = 0;
    for (let j = -4; j <= 4; j++) for (let i = -4; i <= 4; i++) sum += image.at(x + i, y + j).reduce((a, b) => a + b) / 3 / 81;
    return sum;
}

/* The page of three.js, whose knot has its shadow on the ground opposite to the sun: dark left of it first, then right of it. */
async function three() {
    /* The GPU has drawn what was asked for, and the browser shows it. */
    const shown = () => page.evaluate(() => new Promise((done) => {
        document.getElementById('picture').getContext('webgl2').readPixels(0, 0, 1, 1, 0x1908, 0x1401, new Uint8Array(4));
        requestAnimationFrame(() => requestAnimationFrame(done));
    }));
    await open('three.html#side=24', served);
    await until('window.dappleFrames > 0 || document.getElementById("message").textContent !== ""');
    must(await message() === '', `it says: ${await message()}`);
    await page.evaluate('document.getElementById("panel").style.display = "none"');
    const seen = [];
    for (const azimuth of [-0.87, 2.27]) {           // the sun from the right, then from the left
        await page.evaluate(`dapplePage.sun.azimuth = ${azimuth}, dapplePage.sun.height = 0.6, window.dappleFrames = 0, dapplePage.redraw()`);
        await until('window.dappleFrames > 0');
        await shown();
        seen.push(png(Buffer.from(await (await page.$('#picture')).screenshot({ captureBeyondViewport: false }))));
    }
    const mean = (image, left) => {
        let sum = 0;
        for (let y = 0.62; y < 0.78; y += 0.01)
            for (let x = 0; x < 0.2; x += 0.01) sum += image.at(Math.floor((left ? 0.08 + x : 0.72 + x) * WIDTH), Math.floor(y * HEIGHT))[0] / 320;
        return sum;
    };
    if (wanted === 'chromium') {                     // a lost context comes back, three.js's objects and ours
        await page.evaluate('window.loser = document.getElementById("picture").getContext("webgl2").getExtension("WEBGL_lose_context"), loser.loseContext()');
        await until('document.getElementById("picture").getContext("webgl2").isContextLost()');
        await wait(100);                             // the event comes after that
        said.length = 0;                             // three.js tells the console of it
        /* The first time it is lost again while the page gives everything to it. */
        await page.evaluate(() => {
            const picture = document.getElementById('picture'), again = (e) => { setTimeout(() => loser.restoreContext(), 50); picture.removeEventListener(e.type, again); };
            window.dappleFrames = 0;
            picture.addEventListener('webglcontextrestored', () => {
                picture.addEventListener('webglcontextlost', again);
                loser.loseContext();
            }, { once: true });
            loser.restoreContext();
        });
        await until('window.dappleFrames > 0');
        await shown();
        must(await message() === '', `it says: ${await message()}`);
        const back = png(Buffer.from(await (await page.$('#picture')).screenshot({ captureBeyondViewport: false })));
        must(difference(back, seen[1]).mean < 0.05, 'after a lost context the picture is another one');
        must(said.every((line) => /Context (Restored|Lost)/.test(line)), `the console has: ${said.join(' | ')}`);
        said.length = 0;
        const azimuth = await page.evaluate('dapplePage.sun.azimuth');
        await page.focus('#picture');
        await page.keyboard.press('ArrowRight');
        must(Math.abs(await page.evaluate('dapplePage.sun.azimuth') - azimuth - 0.1) < 1e-6, 'an arrow does not turn the sun');
    }
    must(mean(seen[0], true) < mean(seen[1], true) - 8, `left: ${mean(seen[0], true)}, ${mean(seen[1], true)}`);
    must(mean(seen[1], false) < mean(seen[0], false) - 8, `right: ${mean(seen[1], false)}, ${mean(seen[0], false)}`);
    must(said.length === 0, `the console has: ${said.join(' | ')}`);
}

/* ---- tests ---- */

const pole = boxes([-0.15, 0, -0.15, 0.15, 1.2, 0.15], [-0.4, 0, -0.4, 0.4, 0.1, 0.4]);

const tests = {
    async index_leads_to_every_page() {
        await open('index.html');
        const links = await page.evaluate('[...document.querySelectorAll("a.card")].map((a) => a.getAttribute("href"))');
        must(links.length === (existsSync(`${folder}/three.html`) ? 6 : 5), `it has ${links.length} cards`);
        for (const link of links) must(existsSync(`${folder}/${link}`), `${link} is missing`);
        must(await page.evaluate('[...document.images].every((i) => i.naturalWidth > 100)'), 'a picture is missing');
        must(await page.evaluate('document.querySelectorAll("iframe").length') === 0, 'a scene began by itself, on the processor');
        must(said.length === 0, `the console has: ${said.join(' | ')}`);
    },
    async index_runs_one_scene_at_a_time_in_its_place() {
        const press = (name) => page.evaluate((n) => document.querySelector(`[data-page="${n}"] button`).click(), name);
        const shown = () => page.evaluate('[...document.images].filter((i) => i.offsetHeight > 0).length');
        const pictures = await shown();
        for (const name of ['filter', 'sky']) {
            await press(name);
            await until(`/pixels/.test(document.querySelector('[data-page="${name}"] .facts').textContent)`);
            const frames = await page.evaluate('[...document.querySelectorAll("iframe")].map((f) => f.src.replace(/.*\\//, ""))');
            must(frames.join() === `${name}.html?here`, `there are ${frames}`);
            must(await shown() === pictures - 1, 'more or less than one picture made room');
        }
        const inside = page.frames().find((f) => f.url().includes('sky.html'));
        const [high, wide] = await inside.evaluate('[document.body.offsetHeight, document.documentElement.scrollWidth - innerWidth]');
        must(high > 100 && wide <= 0, `within, ${high} high, ${wide} too wide`);
        await until(`Math.abs(document.querySelector("iframe").offsetHeight - ${high}) < 3`);
        must(await inside.evaluate('document.getElementById("message").textContent') === '', 'the scene has a message');
    },
    async index_fits_a_phone_with_a_scene_and_without() {
        const wide = () => page.evaluate('document.documentElement.scrollWidth');
        await page.setViewport({ width: 360, height: 640 });
        await until('document.querySelector("iframe").offsetWidth < 360');
        const alive = await wide();
        await page.evaluate('document.querySelector(".alive button").click()');
        const stopped = await wide();
        await page.setViewport({ width: WIDTH, height: HEIGHT });
        must(alive <= 360 && stopped <= 360, `it is ${alive} and ${stopped} wide`);
    },
    async index_shows_the_picture_again_of_what_was_stopped() {
        must(await page.evaluate('document.querySelectorAll("iframe").length') === 0, 'a scene goes on');
        must(await page.evaluate('[...document.images].every((i) => i.offsetHeight > 50)'), 'a picture is missing');
        must(said.length === 0, `the console has: ${said.join(' | ')}`);
    },
    /* Laid out as with the longest texts, but no program is started: what it draws is another test's. */
    async every_page_fits_a_phone_and_hides_no_control() {
        const bad = [];
        for (const name of ['index', 'product', 'room', 'game', 'sky', 'filter', 'three'].filter((n) => existsSync(`${folder}/${n}.html`))) {
            if (page) await page.close();
            page = await newPage();
            await page.setViewport({ width: 390, height: 844 });
            const errors = [];
            page.on('pageerror', (e) => errors.push(e.message));
            await page.evaluateOnNewDocument(() => { for (const f of ['compile', 'instantiate', 'instantiateStreaming']) WebAssembly[f] = () => new Promise(() => {}); });
            await page.goto(name === 'three' ? `${served}/three.html` : `file://${folder}/${name}.html`);
            const found = await page.evaluate(() => {
                const element = (id) => document.getElementById(id), root = document.documentElement, list = [];
                const long = '96 x 96 maps, 123.4 MB, built in 123.4 s, and a_name_of_a_file_that_is_rather_long_because_somebody_likes_it.glb';
                if (element('facts')) element('facts').textContent = long;
                for (const details of document.querySelectorAll('details')) details.open = true;
                if (element('work')) element('work').style.display = 'flex';
                for (const facts of document.querySelectorAll('.facts')) facts.textContent = long;
                if (root.scrollWidth > innerWidth) list.push(`it is ${root.scrollWidth} wide`);
                const panel = element('panel');
                if (panel && panel.scrollWidth > panel.clientWidth) list.push(`its panel is ${panel.scrollWidth} wide, of ${panel.clientWidth}`);
                const picture = element('picture');
                if (picture && picture.getBoundingClientRect().bottom > panel.getBoundingClientRect().top + 1) list.push('the panel lies on the picture');
                const controls = [...document.querySelectorAll('button, select, input, a[href], .file')].filter((c) => c.offsetWidth > 1);
                for (const c of controls) {
                    c.scrollIntoView({ block: 'center' });
                    const r = c.getBoundingClientRect(), named = `${c.localName} ${c.id || c.textContent.slice(0, 20)}`;
                    const [x, y] = [(r.left + r.right) / 2, (r.top + r.bottom) / 2], top = document.elementFromPoint(x, y);
                    const box = (panel ?? document.body).getBoundingClientRect(), padding = parseFloat(getComputedStyle(panel ?? document.body).paddingRight);
                    if (r.left < box.left || r.right > box.right - padding + 0.5 || r.top < 0 || r.bottom > innerHeight) list.push(`${named} is clipped: ${Object.values(r.toJSON())}`);
                    else if (!top || !(c.contains(top) || top.contains(c))) list.push(`${named} lies below ${top?.localName} ${top?.id}`);
                }
                for (const c of document.querySelectorAll('input, select, progress, canvas'))
                    if (!c.labels?.length && !c.getAttribute('aria-label')) list.push(`${c.localName} ${c.id} has no name`);
                scrollTo(0, 0);
                if (panel) panel.scrollTo(0, 0);
                return { list, controls: controls.length };
            });
            if (process.env.PHONE) writeFileSync(`${process.env.PHONE}/phone-${name}.png`, await page.screenshot());
            /* Whoever is quicker than the program breaks nothing. */
            if (name !== 'index') await page.evaluate(() => {
                for (const c of document.querySelectorAll('#panel button')) c.click();
                for (const c of document.querySelectorAll('#panel select, #panel input')) for (const kind of ['input', 'change']) c.dispatchEvent(new Event(kind));
                const picture = document.getElementById('picture'), at = { pointerId: 1, buttons: 1, clientX: 100, clientY: 100 };
                picture.setPointerCapture = () => {};
                for (const kind of ['pointerdown', 'pointermove', 'pointerup']) picture.dispatchEvent(new PointerEvent(kind, at));
            });
            if (errors.length) found.list.push(`before its program is there: ${errors.join(', ')}`);
            if (found.list.length || found.controls < 1) bad.push(`${name}, ${found.controls} controls: ${found.list.join('; ')}`);
        }
        must(bad.length === 0, bad.join(' | '));
    },
    async index_begins_what_is_scrolled_to_where_a_gpu_draws() {
        if (page) await page.close();
        page = await newPage();
        await page.evaluateOnNewDocument(() => {
            const real = WebGL2RenderingContext.prototype.getParameter;
            WebGL2RenderingContext.prototype.getParameter = function (name) { return name === 0x9246 ? 'A card' : real.call(this, name); };
        });
        await page.goto(`${served}/index.html`);          // three.js wants a server
        for (const name of ['filter', 'sky', 'three'].filter((n) => existsSync(`${folder}/${n}.html`))) {
            await page.evaluate((n) => document.querySelector(`[data-page="${n}"]`).scrollIntoView({ block: 'center' }), name);
            await until(`[...document.querySelectorAll("iframe")].map((f) => f.src.replace(/.*\\//, "")).join() === "${name}.html?here"`);
        }
        if (existsSync(`${folder}/three.html`)) await until(`/pixels/.test(document.querySelector('[data-page="three"] .facts').textContent)`);
    },
    async index_without_webgl_2_shows_pictures_and_says_why() {
        if (page) await page.close();
        page = await newPage();
        await page.evaluateOnNewDocument('HTMLCanvasElement.prototype.getContext = () => null');
        await page.goto(`file://${folder}/index.html`);
        must(/no WebGL 2/.test(await page.evaluate('document.getElementById("reason").innerText')), 'it does not say why');
        must(await page.evaluate('[...document.querySelectorAll(".scene button")].every((b) => b.offsetHeight === 0)'), 'a button is there');
        must(await page.evaluate('[...document.images].every((i) => i.naturalWidth > 100 && i.offsetHeight > 50)'), 'a picture is missing');
    },
    /* QUIET=1, on a machine that has nothing else to do, holds the limit at 640 x 360; elsewhere the time is only said. */
    async product_shows_its_first_picture_within_3_seconds() {
        if (page) await page.close();
        page = await newPage();
        await page.setViewport(process.env.QUIET ? { width: 640, height: 360 } : { width: WIDTH, height: HEIGHT });
        said = [];
        page.on('console', (m) => said.push(m.text()));
        page.on('pageerror', (e) => said.push(e.message));
        await page.evaluateOnNewDocument(() => {
            /* The page asks busy() and draws the next frame at once: what it notes of the first one's end tells. */
            const look = () => { if (window.dappleCost !== undefined) window.firstPicture = performance.now(); else setTimeout(look, 10); };
            setTimeout(look, 10);
        });
        await page.goto(`file://${folder}/product.html`);
        await until('window.firstPicture > 0');
        const seconds = await page.evaluate('window.firstPicture / 1000');
        console.log(`product: first picture after ${seconds.toFixed(2)} s, of ${await page.evaluate('`${canvas.width} x ${canvas.height}`')}`);
        must(await message() === '', `it says: ${await message()}`);
        must(said.length === 0, `the console has: ${said.join(' | ')}`);
        must(!process.env.QUIET || seconds < 3, `the first picture came after ${seconds} s`);
        await page.setViewport({ width: WIDTH, height: HEIGHT });
    },
    async maps_grow_finer_while_the_picture_is_there() {
        must(await page.evaluate('state.stages[0] === 16 && state.ready'), 'the first maps were not those of 16 x 16 directions');
        must(await page.evaluate('made() !== null && DappleProduct.first.block.length > 5e4 && DappleProduct.first.block.length < 1e5'), 'they have not come with the page');
        await until('!state.finer');                 // a worker builds the others once the first picture is there
        must(await page.evaluate('state.worker !== null'), 'finer maps are not built');
        await page.evaluate('FULL = 1, SIDES.splice(0, 3, [8, 32], [16, 64], [96, 128]), build()');
        await until('state.stages.length > 1');
        must(await page.evaluate('state.stages[0] === 8 && state.stages[1] === 16 && state.worker && state.ready'), 'the maps that came');
        must(await page.evaluate('!document.getElementById("save").disabled'), 'the maps cannot be saved');
    },
    async other_maps_and_other_questions_are_asked_for_by_knobs() {
        const set = (id, value, type) => page.evaluate((i, v, t) => { const e = element(i); e.value = v; e.dispatchEvent(new Event(t)); }, id, value, type);
        await set('pixels', 32, 'change');
        await set('depthbits', 4, 'change');
        await set('side', 16, 'change');
        await built();
        must(await page.evaluate('state.stages.join() === "16"'), 'the maps that came');
        const facts = await page.evaluate('element("facts").textContent');
        must(/^16 x 16 maps/.test(facts), `the page says: ${facts}`);
        const mean = (image) => { let sum = 0; for (let y = 0; y < HEIGHT; y += 2) for (let x = 0; x < WIDTH; x += 2) sum += image.at(x, y)[1]; return sum; };
        await page.evaluate('FULL = 2, adapt = () => {}, state.scale = 0.5');
        const draw = async () => { await changed(); await settled(2); return picture(); };
        const before = await draw();
        await set('filter', 0, 'input');
        must(difference(await draw(), before).mean > 0.02, 'another filter changes nothing');
        await set('filter', 2, 'input');
        await set('offset', 4, 'input');
        must(mean(await draw()) > mean(before), 'receivers that are moved off the model are not lighter');
        must(await message() === '' && said.length === 0, `it says: ${await message()} ${said.join(' | ')}`);
        await set('offset', 1, 'input');
        await page.evaluate('SIDES.splice(0, 3, [16, 64], [48, 128], [96, 128]), build()');
    },
    async building_can_be_cancelled() {
        await page.evaluate('document.getElementById("cancel").click()');
        must(await page.evaluate('state.worker === null && state.ready'), 'the worker goes on');
    },
    async a_shadow_follows_the_sky() {
        await page.evaluate('SIDES.splice(0, 3, [24, 64]), FULL = 8, adapt = () => {}, state.scale = 0.5');     // brightness alone is asked for
        await drop('sunny.hdr', sunnySky());
        await drop('pole.glb', pole);
        must(await message() === '', `it says: ${await message()}`);
        await built();
        await page.evaluate('window.test = { center: [0, 0.6, 0], radius: Math.hypot(0.4, 0.6, 0.4) }; view.elevation = 0.9; samples.value = 2');
        /* The sun stands over +X first, then, turned by 90 degrees about +Y, over -Z. */
        for (const [angle, dark, lit] of [[0, [-0.8, 0, 0], [0.8, 0, 0]], [90, [0, 0, 0.8], [0, 0, -0.8]], [180, [0.8, 0, 0], [-0.8, 0, 0]]]) {
            await page.evaluate(`document.getElementById("turn").value = ${angle}`);
            await changed();
            await settled(8);
            const image = await picture(), a = await brightness(image, dark), b = await brightness(image, lit);
            must(a < 0.75 * b, `turned by ${angle}: shadow ${a}, light ${b}`);
        }
    },
    async dragging_turns_the_sky_and_the_camera() {
        const before = await page.evaluate('[+document.getElementById("turn").value, view.azimuth]');
        await page.mouse.move(120, 40);
        await page.mouse.down({ button: 'right' });
        await page.mouse.move(160, 40, { steps: 4 });
        await page.mouse.up({ button: 'right' });
        const turned = await page.evaluate('[+document.getElementById("turn").value, view.azimuth]');
        must(turned[0] !== before[0] && turned[1] === before[1], `the sky: ${before} ${turned}`);
        await page.mouse.down();
        await page.mouse.move(120, 40, { steps: 4 });
        await page.mouse.up();
        must(await page.evaluate('view.azimuth') < before[1], 'the camera did not turn');
        await page.focus('#picture');
        await page.keyboard.press('a');
        must(await page.evaluate('+document.getElementById("turn").value') === turned[0] - 5, 'the key a');
    },
    /* The picture is 144 pixels high: two fingers that go right by half of that turn the sky by 90 degrees. */
    async fingers_turn_the_camera_and_the_sky_and_its_shadow_and_go_nearer() {
        const now = () => page.evaluate('({ turn: +document.getElementById("turn").value, ...view })');
        const near = (a, b) => Math.abs(a - b) < 0.03 * Math.max(1, Math.abs(b));
        await page.evaluate('turn(-element("turn").value), Object.assign(view, { azimuth: 0.9, elevation: 0.9 })');
        const first = await now();
        await touch([[120, 60], [132, 66], [144, 72]]);
        const looked = await now();
        must(near(looked.azimuth, first.azimuth + 0.5) && near(looked.elevation, first.elevation + 0.25) && looked.turn === 0
            && looked.distance === first.distance, `one finger: ${JSON.stringify(looked)}, before ${JSON.stringify(first)}`);
        await touch([[100, 50], [136, 50], [172, 50]], [[60, 80], [96, 80], [132, 80]]);
        const turned = await now();
        must(near(turned.turn, 90) && near(turned.distance, first.distance) && turned.azimuth === looked.azimuth, `two fingers: ${JSON.stringify(turned)}`);
        await page.evaluate(`turn(${90 - turned.turn}), view.azimuth = 0.9, view.elevation = 0.9`);
        await changed();
        await settled(8);
        const image = await picture(), a = await brightness(image, [0, 0, 0.8]), b = await brightness(image, [0, 0, -0.8]);
        must(a < 0.75 * b, `with the sky turned by fingers: shadow ${a}, light ${b}`);
        await touch([[108, 72], [98, 72], [88, 72]], [[148, 72], [158, 72], [168, 72]]);        // from 40 apart to 80
        const pinched = await now();
        must(near(pinched.distance, turned.distance / 2) && near(pinched.turn, 90), `spread: ${JSON.stringify(pinched)}`);
        await touch([[88, 72], [108, 72]], [[168, 72], [148, 72]]);
        must(near((await now()).distance, turned.distance), 'fingers that come together do not go away again');
    },
    async each_key_does_what_the_page_says() {
        const keys = { ArrowLeft: ['azimuth', -0.1], ArrowRight: ['azimuth', 0.1], ArrowUp: ['elevation', 0.1], ArrowDown: ['elevation', -0.1],
            a: ['turn', -5], d: ['turn', 5], '+': ['distance', 0.9], '-': ['distance', 1.1] };
        const now = () => page.evaluate('({ turn: +document.getElementById("turn").value, ...view })');
        await page.focus('#picture');
        for (const [key, [what, by]] of Object.entries(keys)) {
            const before = await now();
            await page.keyboard.press(key);
            const after = await now(), wanted = what === 'distance' ? before[what] * by : before[what] + by;
            must(Math.abs(after[what] - wanted) < 1e-6, `${key}: ${what} is ${after[what]}, not ${wanted}`);
            for (const other of Object.keys(before)) must(other === what || after[other] === before[other], `${key} changes ${other}`);
        }
        const still = JSON.stringify(await now());   // with Ctrl they are the browser's
        await page.keyboard.down('Control');
        for (const key of ['d', 'ArrowLeft']) await page.keyboard.press(key);
        await page.keyboard.up('Control');
        must(JSON.stringify(await now()) === still, 'keys with Ctrl turn something');
        /* Every control can be reached without a mouse, in the order of the page. */
        await page.evaluate('document.activeElement.blur()');
        const wanted = await page.evaluate('[...document.querySelectorAll("canvas, #panel button, #panel select, #panel input, #panel a, #panel summary")]'
            + '.filter((c) => c.checkVisibility() && !c.disabled).length'), reached = new Set();
        for (let i = 0; i < wanted + 4; i++) {
            await page.keyboard.press('Tab');
            reached.add(await page.evaluate('document.activeElement === document.body ? "" : document.activeElement.outerHTML.slice(0, 80)'));
        }
        reached.delete('');
        must(reached.size === wanted, `Tab comes to ${reached.size} of ${wanted} controls: ${[...reached].join(' ')}`);
    },
    async normal_maps_tilt_a_surface_to_the_light() {
        await page.evaluate('SIDES.splice(0, 3, [16, 64]), view.elevation = 0.8, view.azimuth = 0.9, turn(-element("turn").value)');
        const seen = [];
        for (const tilt of [-0.5, 0, 0.5]) {                    // away from the sun over +X, level, to it
            await drop(`plate${tilt}.glb`, plate(tilt, 0, Math.sqrt(1 - tilt * tilt)));
            must(await message() === '', `it says: ${await message()}`);
            await built();
            await changed();
            await settled(8);
            seen.push(at(await picture(), [0, 0]));
        }
        must(seen[0] + 15 < seen[1] && seen[1] + 5 < seen[2], `tilted away, level, tilted to the sun: ${seen}`);
    },
    async maps_of_roughness_and_metal_are_shown() {
        const seen = [];
        for (const [rough, metal] of [[1, 0], [1, 1], [0.25, 1]]) {     // the sun is mirrored away from the camera
            await drop(`metal${rough}${metal}.glb`, plate(0, rough, metal, true));
            must(await message() === '', `it says: ${await message()}`);
            await built();
            await changed();
            await settled(8);
            seen.push(at(await picture(), [0, 0]));
        }
        console.log(`rough and no metal, rough metal, smooth metal: ${seen.map((v) => v.toFixed(1))}`);
        must(seen[1] < seen[0] - 10 && seen[2] < seen[1] - 15, `rough and no metal, rough metal, smooth metal: ${seen}`);
    },
    async the_picture_is_the_native_one() {
        writeFileSync(`${scratch}/pole.glb`, pole);
        writeFileSync(`${scratch}/sunny.hdr`, sunnySky());
        await page.setViewport({ width: WIDTH / 2, height: HEIGHT / 2 });
        await page.evaluate('SIDES.splice(0, 3, [24, 64]), FULL = 32, state.scale = 1, turn(-element("turn").value)');
        await page.evaluate('Object.assign(view, { azimuth: 0.9, elevation: 0.35, distance: 3.6, up: -0.1 })');
        await drop('pole.glb', pole);
        await built();
        await changed();
        await settled(32);
        const shown = await picture();
        const d = difference(shown, twin(native, [`${scratch}/pole.glb`, `${scratch}/sunny.hdr`, shown.width, shown.height, 32, 24, 64, 0,
            `${scratch}/native.png`]));
        console.log(`product: mean difference ${d.mean.toFixed(3)}, beyond 8: ${(100 * d.far).toFixed(2)} %`);
        must(d.mean < 0.5 && d.far < 0.002, `mean difference ${d.mean}, share of pixels beyond 8 ${d.far}`);
        await page.setViewport({ width: WIDTH, height: HEIGHT });
        await page.evaluate('FULL = 4');
    },
    async maps_that_were_saved_are_given_again() {
        await page.evaluate('state.scale = 0.5');
        const draw = async () => { await changed(); await settled(4); return picture(); };
        const fine = await draw();
        const saved = await page.evaluate(async () => {
            const real = HTMLAnchorElement.prototype.click;
            let link;
            HTMLAnchorElement.prototype.click = function () { link = this; };
            element('save').click();
            HTMLAnchorElement.prototype.click = real;
            const bytes = new Uint8Array(await (await fetch(link.href)).arrayBuffer());
            return { name: link.download, text: btoa(bytes.reduce((s, b) => s + String.fromCharCode(b), '')) };
        });
        must(saved.name === 'pole.csm', `it is called ${saved.name}`);
        await page.evaluate('SIDES.splice(0, 3, [4, 8])');
        await drop('pole.glb', pole);
        await built();
        const coarse = difference(await draw(), fine);
        await drop(saved.name, Buffer.from(saved.text, 'base64'));
        must(await message() === '', `it says: ${await message()}`);
        const again = difference(await draw(), fine);
        must(coarse.far > 0.003 && again.mean < 0.02, `4 x 4 maps change ${100 * coarse.far} % of the pixels, those that were saved the mean by ${again.mean}`);
        await page.evaluate('SIDES.splice(0, 3, [24, 64])');
    },
    async hostile_files_give_a_message_and_the_page_lives_on() {
        const deep = '['.repeat(20000) + ']'.repeat(20000);
        const files = { 'noise.glb': Buffer.from('glTFnoise'.repeat(50)), 'deep.glb': glb(`{"asset":{"version":"2.0"},"extras":${deep}}`, Buffer.alloc(4)),
            'cut.hdr': sunnySky().subarray(0, 500), 'cut.csm': Buffer.from('CSM'.repeat(100)), 'some.txt': Buffer.from('text') };
        await page.evaluate('FULL = 1');
        for (const [name, bytes] of Object.entries(files)) {
            await drop(name, bytes);
            must(await message() !== '', `${name} gave no message`);
            must(await page.evaluate('state.model') === 'pole.glb', `${name} took the model away`);
            await changed();
            await settled(1);
        }
        await drop('pole.glb', Buffer.from('no model'));      // the name of the model that is there, which a lost context needs again
        must(await message() !== '', 'a broken pole.glb gave no message');
        must(await page.evaluate('state.files.get("pole.glb").length') === pole.length, 'a broken file took the place of the model of its name');
        await page.evaluate('take({ name: "a folder", arrayBuffer: () => Promise.reject(new Error("a folder")) })');
        must(await message() === 'a_folder: it cannot be read', `of a folder the page says: ${await message()}`);
        /* What breaks the program in the worker is told of, too, and leaves no worker. */
        await page.evaluate('window.kept = state.files.get("pole.glb"), state.files.set("pole.glb", 5), build()');
        await until('!state.worker', 60000);
        must(/^building failed/.test(await message()), `the worker broke, and the page says: ${await message()}`);
        await page.evaluate('state.files.set("pole.glb", kept)');
        await drop('line.hdr', Buffer.concat([Buffer.from('#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1024\n'), Buffer.alloc(4096, 128)]));
        must(await message() === '', `a sky of one row is refused: ${await message()}`);
        await drop('sunny.hdr', sunnySky());
    },
    async a_lost_context_comes_back() {
        await page.evaluate('FULL = 2');
        await drop('pole.glb', pole);
        await built();
        await survives(2, 0.05);
        /* A broken model that is dropped meanwhile is left out. */
        await page.evaluate('SIDES.splice(0, 3, [4, 8]), loser.loseContext()');
        await until('state.lost');
        await drop('noise.glb', Buffer.from('glTFnoise'.repeat(50)));
        await page.evaluate('loser.restoreContext()');
        await until('!state.lost');
        await built();
        await changed();
        await settled(2);
        must(await page.evaluate('[state.model, state.blockOf, element("model").value].join()') === 'builtin:knot,builtin:knot,builtin:knot', 'it shows another model');
        must(await message() !== '', 'a broken model gave no message');
    },
    /* What the program has taken of its memory, and objects of GL that are there. */
    async ten_models_take_the_memory_of_two() {
        const taken = [];
        await page.evaluate(() => {
            FULL = 1;
            SIDES.splice(0, 3, [16, 64]);
            window.alive = { Texture: 0, Buffer: 0, Framebuffer: 0, VertexArray: 0, Program: 0, Shader: 0 };
            window.made = 0;
            for (const kind of Object.keys(alive))
                for (const [verb, by] of [['create', 1], ['delete', -1]]) {
                    const real = state.context[verb + kind].bind(state.context);
                    state.context[verb + kind] = (what) => { if (by > 0 || what) alive[kind] += by; made += by > 0; return real(what); };
                }
        });
        for (let i = 1; i <= 10; i++) {
            await drop(`model${i}.glb`, boxes([-0.3, 0, -0.3, 0.3, 0.5 + 0.05 * i, 0.3]));
            await built();
            await changed();
            await settled(1);
            taken.push(await page.evaluate('({ bytes: state.program.ccall("pd_memory", "number", [], []), room: state.program.HEAPU8.length, '
                + 'files: state.files.size, objects: JSON.stringify(alive), made })'));
        }
        const [two, ten] = [taken[1], taken[9]];
        console.log(`after two models ${JSON.stringify(two)}, after ten ${JSON.stringify(ten)}`);
        must(two.bytes > 100000 && ten.bytes < 1.1 * two.bytes && ten.room === two.room && ten.files === two.files, 'there is more memory taken');
        must(ten.objects === two.objects && ten.made > two.made + 16, 'there are more objects of GL');
    },
    async each_control_of_the_product_page_matters() {
        await page.evaluate('state.scale = 1, turn(-element("turn").value)');
        /* As the page begins: the tests above have moved some. */
        await page.evaluate('document.querySelectorAll("#panel input[type=range]").forEach((c) => { c.value = c.defaultValue; })');
        await drop('sunny.hdr', sunnySky());
        await page.evaluate('SIDES.splice(0, 3, [16, 64]), load("builtin:plant")');       // leaves are open
        await each_control_matters([['turn', 60], ['exposure', 1], ['samples', 0], ['show'], ['filter', 0], ['offset', 0], ['bias', 0], ['sampling', 1],
            ['side', 8], ['pixels', 32], ['thickness', 0.5], ['depthbits', 4], ['layers', 2], ['fast', 1, true], ['sky', 'builtin:overcast'],
            ['model', 'builtin:figure']], ['open']);
    },
    /* The user is quicker than the program, and the context is lost while it comes. */
    async what_was_chosen_before_the_program_was_there_is_taken() {
        await open('product.html', undefined, 0.5, `const real = WebAssembly.compile;
            WebAssembly.compile = (bytes) => new Promise((go) => { window.goOn = go; }).then(() => real.call(WebAssembly, bytes));`);
        await page.evaluate(() => {
            SIDES.splice(0, 3, [8, 32]);
            FULL = 1;
            for (const [list, value] of [['model', 'builtin:figure'], ['sky', 'builtin:overcast']]) {
                element(list).value = value;
                element(list).dispatchEvent(new Event('change'));
            }
            window.loser = state.context.getExtension('WEBGL_lose_context');
        });
        for (let i = 0; i < 2; i++) {
            await page.evaluate('loser.loseContext()');
            await until('state.lost');
            must(await message() !== '', 'a lost context is not spoken of');
            if (i === 1) {
                await page.evaluate('goOn()');
                await until('!!state.program');
            }
            await page.evaluate('loser.restoreContext()');
            await until('!state.lost');
        }
        await built();
        await settled(1);
        must(await page.evaluate('[state.model, state.blockOf, state.sky, state.stages].join()') === 'builtin:figure,builtin:figure,builtin:overcast,8', 'it shows something else');
        must(await message() === '' && said.length === 0, `it says: ${await message()} ${said.join(' | ')}`);
    },
    async a_lamp_is_aimed_at_another_wall_of_the_room() {
        const before = await scene('room', { mean: 1, far: 0.01 });
        await page.setViewport({ width: WIDTH / 2, height: HEIGHT / 2 });      // the rest asks for brightness alone
        await page.evaluate('FULL = 1; window.dappleFrames = 0, moved()');
        await settled(1);
        const aim = await page.evaluate('handleAt(1)'), wall = [0.55, 0.1];
        await drag(aim.slice(3), wall, false, 1);
        const after = await picture(), now = await page.evaluate('handleAt(1)');
        must(now[0] > aim[0] + 1, `the lamp shines at ${now}, and did at ${aim}`);
        must(at(after, [0.4, 0.1]) > at(before, [0.4, 0.1]) + 40, 'where the lamp shines now it is no brighter');
        const dark = [0.2, -0.5], without = await page.evaluate('document.getElementById("bounce").value = 0, window.dappleFrames = 0, moved()').then(() => settled(1)).then(picture);
        must(at(after, dark) > at(without, dark) + 10, `bounced light on the floor: ${at(after, dark)}, without ${at(without, dark)}`);
        if (process.env.LONG) await page.evaluate('document.getElementById("bounce").value = 2').then(() => survives(1, 2));
    },
    async each_control_of_the_room_matters() {
        for (const [knob, few] of [[3, 4], [4, 6]]) await page.evaluate(`document.querySelector('[data-knob="${knob}"]').value = ${few}`);
        await each_control_matters([['0', 2], ['1', 1], ['2', 40], ['3', 5], ['4', 7], ['5', 5], ['6', 2], ['7', 0], ['8', 0], ['9', 0.1], ['17', 1], ['10', 0],
            ['0', 1], ['11', 5], ['12', 6], ['13', 3], ['14', 2], ['15', 0.2], ['16', 0]], ['play']);
    },
    async a_piece_and_a_lamp_are_dragged_and_shadows_follow() {
        const large = await scene('game', { mean: 1, far: 0.01 });
        /* Half as large it is the same: there SwiftShader once hid the board in two frames of four, below a ground that was too large. */
        await page.setViewport({ width: WIDTH / 2, height: HEIGHT / 2 });
        await page.evaluate('adapt = () => {}; window.dappleFrames = 0, moved()');
        await settled(4);
        const off = difference(await picture(), shrunk(large, WIDTH / 2)).mean;
        must(off < 6, `the picture of half the size is off by ${off}`);
        await page.setViewport({ width: 0.75 * WIDTH, height: 0.75 * HEIGHT });
        await page.evaluate('FULL = 1; document.querySelector("[data-knob=\\"2\\"]").value = 1; window.dappleFrames = 0, moved()');
        await settled(1);
        const pawn = 2 + 9, free = [0.1375, 0.03, 0.0275], other = [0.16, 0.25, -0.06];     // it stands on e4; g4 is free
        const [lamp, home] = [await page.evaluate('handleAt(0)'), await page.evaluate(`handleAt(${pawn})`)];
        const window_at = (p) => page.evaluate((q) => {
            const at = state.program.ccall('pg_window_at', 'number', ['number', 'number', 'number'], q) / 4;
            return [...state.program.HEAPF32.subarray(at, at + 2)];
        }, p);
        /* The board 22 mm behind the pawn's middle, seen from a lamp. */
        const behind = ([x, , z]) => {
            const d = [home[0] - x, home[2] - z], length = Math.hypot(...d);
            return [home[0] + 0.022 * d[0] / length, 0, home[2] + 0.022 * d[1] / length];
        };
        const light = (image, point) => (at(image, point) / 255) ** 2.2;
        const first = await window_at(behind(lamp)), second = await window_at(behind(other)), seen = [];
        for (const [i, where] of [[pawn, free], [0, other], [pawn, home.slice(0, 3)]]) {
            seen.push(await picture());
            await drag((await page.evaluate(`handleAt(${i})`)).slice(3), await window_at(where), i === 0, 1);  // the lamp by a finger
            const now = await page.evaluate(`handleAt(${i})`);
            must(Math.hypot(now[0] - where[0], now[2] - where[2]) < 0.003, `dragged to ${where}, it stands at ${now}`);
        }
        seen.push(await picture());
        /* What is left of a point's light where the pawn stands on e4: of the first lamp, and of the other one. */
        const left = (point) => [light(seen[0], point) / light(seen[1], point), light(seen[3], point) / light(seen[2], point)];
        const [a, b] = [left(first), left(second)];
        console.log(`light left behind the pawn: ${a.map((v) => v.toFixed(3))} of two lamps, on its other side ${b.map((v) => v.toFixed(3))}`);
        must(a[0] < 0.82 && b[1] < 0.82, `behind the pawn there is ${a[0]} and ${b[1]} of the light without it`);
        must(a[1] > a[0] + 0.1 && b[0] > b[1] + 0.1, `the shadow stays where it was: ${a}, ${b}`);
        if (process.env.LONG) await page.setViewport({ width: WIDTH / 4, height: HEIGHT / 4 }).then(() => survives(1, 1));
        must(await message() === '' && said.length === 0, `it says: ${await message()} ${said.join(' | ')}`);
    },
    async each_control_of_chess_matters() {
        await each_control_matters([['0', 100], ['1', 0.4], ['2', 2], ['6', 1], ['5', 3], ['4', 4], ['3', 3]], []);
    },
    async a_shadow_of_the_washing_follows_the_sky() {
        const before = await scene('sky', { mean: 1, far: 0.01 });
        await page.evaluate('document.getElementById("turn").value = -140, window.dappleFrames = 0, moved()');
        await settled(2);
        const after = await picture(), ground = [0.1, -0.45];        // in front of the washing
        must(at(after, ground) < at(before, ground) - 25, `with the sun behind ${at(after, ground)}, before ${at(before, ground)}`);
        await survives(4, 1);
    },
    async each_control_of_the_washing_matters() {
        await each_control_matters([['0', 100], ['1', 1], ['7', 2], ['8', 2], ['6', 4], ['5', 5], ['3', 3], ['4'], ['10'], ['11'], ['9', 1], ['2', 3]], ['play']);
    },
    /* What stands is off by less the more frames and neighbours count, and most without both. */
    async noise_is_shown_beside_what_the_filter_leaves_of_it() {
        const image = await scene('filter', { mean: 1, far: 0.01 });
        const rough = (side) => {                   // differences of neighbours on the back wall
            let sum = 0;
            for (let y = 0.3; y < 0.6; y += 0.01)
                for (let x = 0.02; x < 0.2; x += 0.01) {
                    const u = Math.floor((0.5 + 0.5 * side * x) * image.width), v = Math.floor((0.5 - 0.5 * y) * image.height);
                    sum += Math.abs(image.at(u, v)[1] - image.at(u + 1, v)[1]);
                }
            return sum;
        };
        must(rough(-1) > 4 * rough(1), `neighbours differ by ${rough(-1)} left of the line, by ${rough(1)} right of it`);
        await halves();
        const error = async (history, passes) => {
            await page.evaluate(`document.querySelector('[data-knob="2"]').value = ${history}; document.querySelector('[data-knob="3"]').value = ${passes};
                window.dappleFrames = 0, moved()`);
            await settled(4);
            return page.evaluate('measure(), window.dappleMeasured');
        };
        const [none, spatial, both] = [await error(1, 0), await error(1, 3), await error(8, 3)];
        console.log(`error of noise ${none[0].toFixed(3)}; of the filter without history and passes ${none[1].toFixed(3)}, with passes `
            + `${spatial[1].toFixed(3)}, with both ${both[1].toFixed(3)}`);
        must(Math.abs(none[1] - none[0]) < 1e-3 * none[0], 'without history and passes light is not as it was gathered');
        must(spatial[1] < 0.5 * spatial[0] && both[1] < spatial[1], 'the filter leaves too much');
        await survives(4, 10);                      // half of it is noise, another in each frame
    },
    async each_control_of_the_filter_matters() {
        await each_control_matters([['1', 1], ['2', 1], ['3', 1], ['4', 0.1], ['5', 1], ['6', 1], ['7'], ['0', 1]], ['play'], 'ask("filter_again")', 2);
    },
    /* PICTURES=FOLDER writes the pictures of the index anew. */
    async index_says_how_far_its_scenes_are_from_a_path_tracers_pictures() {
        const bad = [], pictures = process.env.PICTURES;
        for (const name of ['room', 'game', 'sky', 'filter']) if (!drawn[name]) await scene(name, { mean: 1, far: 0.01 });
        if (!drawn.filter.noisy) await halves();
        await open('product.html');
        await until('state.ready');
        await page.evaluate('SIDES.splice(0, 3, [48, 128]), FULL = 16, adapt = () => {}, samples.value = 2, load("builtin:knot")');
        await built();
        await changed();
        await settled(16);
        drawn.product = { shown: await picture(), program: native,
            values: (width, height) => ['builtin:knot', 'builtin:sky', width, height, 16, 48, 128, 0, `${scratch}/native.png`] };
        await open('index.html');
        for (const [name, { shown, noisy, program, values }] of Object.entries(drawn)) {
            const paths = name === 'filter' ? 512 : 128;    // a spot that is small sends all of its light on
            if (pictures) {
                twin(program, values(2 * WIDTH, 2 * HEIGHT), 4 * paths);
                copyFileSync(`${scratch}/native.png`, `${pictures}/web-${name}-exact.png`);
            }
            const exact = png(readFileSync(`${pictures || folder}/web-${name}-exact.png`));
            const off = difference(shrunk(shown, WIDTH / 2), shrunk(exact, WIDTH / 2));
            /* Few paths, and the mean of 16 pixels of them: whether the picture is still that of the scene. */
            const traced = twin(program, values(WIDTH / 2, HEIGHT / 2), paths) ?? exact;
            const anew = difference(shrunk(traced, WIDTH / 8), shrunk(exact, WIDTH / 8));
            const stated = +await page.evaluate(`document.querySelector('[data-page="${name}"] .off').textContent`);
            const text = `${name}: off by ${off.mean.toFixed(2)} of 255, the index says ${stated}; its exact picture by ${anew.mean.toFixed(2)}`;
            console.log(text);
            if (!(off.mean < 1.15 * stated && off.mean > 0.85 * stated && anew.mean < 2.5)) bad.push(text);
            if (!noisy) continue;
            const rough = difference(shrunk(noisy, WIDTH / 2), shrunk(exact, WIDTH / 2)).mean, told = +await page.evaluate('document.querySelector(".noise").textContent');
            console.log(`${name}, as gathered: off by ${rough.toFixed(2)}, the index says ${told}`);
            if (!(rough < 1.15 * told && rough > 0.85 * told)) bad.push(`the noise is off by ${rough}, not ${told}`);
        }
        must(bad.length === 0, bad.join(' | '));
    },
    three_js_draws_with_our_shadows: three,
    async the_module_of_csm_is_under_250_kb_compressed() {
        const bytes = ['dapple.wasm.wasm', 'dapple.wasm.mjs', 'dapple.mjs'].map((f) => gzipSync(readFileSync(`${folder}/${f}`), { level: 9 }).length);
        console.log(`csm.h and gl_csm.h with all GLSL: ${bytes[0]} bytes compressed, JavaScript ${bytes[1]} and ${bytes[2]}`);
        must(bytes.reduce((a, b) => a + b) < 250 * 1024, `${bytes} bytes`);
    },
    /* Without the two headers a page may not have threads, and builds all the same. */
    async threads_build_the_bytes_of_one_thread_where_the_page_may_have_them() {
        const blocks = [];
        for (const [from, may] of [[served, false], [isolated, true]]) {
            await open('index.html', from);
            const seen = await page.evaluate(async (base) => {
                const d = await import(`${base}/dapple.mjs`), positions = [], list = [];
                for (let i = 0; i < 900; i++) for (let k = 0; k < 9; k++)
                    positions.push(Math.sin(i * 1.7 + k % 3) + 0.2 * Math.sin(i * 0.3 + k * 2.1));
                for (const threads of [1, 4, undefined]) {
                    let took = 0;
                    const block = await d.build({ positions }, { side: 24, mapSide: 64, threads, onThreads: (n) => { took = n; } });
                    const hash = new Uint8Array(await crypto.subtle.digest('SHA-256', block));
                    list.push({ threads, took, bytes: block.length, hash: [...hash].join() });
                }
                return { may: d.mayThread(), list };
            }, from);
            console.log(`${may ? 'with' : 'without'} the headers: ${seen.list.map((b) => `${b.took} of ${b.threads ?? 'all'}, ${b.bytes} bytes`).join('; ')}`);
            must(seen.may === may, `mayThread() is ${seen.may}`);
            must(seen.list[0].took === 1 && (may ? seen.list[1].took > 1 && seen.list[1].took <= 4 : seen.list[1].took === 1 && seen.list[2].took === 1),
                `threads that took part: ${seen.list.map((b) => b.took)}`);
            must(said.length === 0, `the console has: ${said.join(' | ')}`);
            blocks.push(...seen.list);
        }
        must(blocks.every((b) => b.bytes > 10000 && b.hash === blocks[0].hash), 'the bytes differ');
    },
    async types_name_what_the_module_has() {
        const [code, types] = ['dapple.mjs', 'dapple.d.ts'].map((f) => readFileSync(`${folder}/${f}`, 'utf8'));
        const all = (text, what) => [...text.matchAll(what)].map((m) => m[1]).sort().join();
        const part = (text, what, from) => new RegExp(`${what} ${from} \\{\\n([^]*?)\\n\\}`).exec(text)[1];
        const given = all(code, /^export (?:async )?(?:function|const) (\w+)/gm), told = all(types, /^export function (\w+)/gm);
        must(given === told && given.split(',').length === 4, `exports ${given}, types of ${told}`);
        for (const name of ['Attached', 'Maps']) {
            const has = all(part(code, 'class', name), /^    (?!constructor)(\w+)\(.*\) \{/gm);
            const said = all(part(types, 'interface', name), /^    (\w+)\(/gm);
            must(has === said && has.split(',').length >= 3, `${name} has ${has}, types of ${said}`);
        }
    },
    async the_module_refuses_what_is_wrong_by_name() {
        const text = (code) => page.evaluate(`(async () => { const d = await import('./dapple.mjs'); try { ${code}; return 'nothing'; } catch (e) { return e.message; } })()`);
        const bad = await text('await d.build({ positions: [0, 0, 0, 1, 0, 0, 0, 1, 0], indices: [0, 1, 7] })');
        must(/index 2 of triangle 0 is 7/.test(bad), `a bad index: ${bad}`);
        const cut = await text('const c = document.createElement("canvas").getContext("webgl2"); (await d.attach(c)).maps([new Uint8Array(100)])');
        must(/cohsm_open/.test(cut), `a block that is none: ${cut}`);
        const stopped = await text('const a = new AbortController(), p = d.build({ positions: [0, 0, 0, 1, 0, 0, 0, 1, 0] }, { signal: a.signal }); a.abort(); await p');
        must(stopped === 'cancelled', `an aborted build: ${stopped}`);
        /* A signal that aborted before, no positions, an option that cannot be sent to a worker: none is built, and no worker stays. */
        const left = await page.evaluate(async () => {
            const d = await import(`${location.origin}/dapple.mjs`), Real = Worker, gone = new AbortController(), seen = [];
            const mesh = { positions: [0, 0, 0, 1, 0, 0, 0, 1, 0] };
            let alive = 0;
            window.Worker = class extends Real { constructor(...of) { super(...of); alive++; } terminate() { alive--; super.terminate(); } };
            gone.abort();
            for (const [m, options] of [[mesh, { signal: gone.signal }], [{}, {}], [mesh, { odd: () => 1 }]])
                await d.build(m, options).then(() => seen.push('built'), () => seen.push('refused'));
            window.Worker = Real;
            return [alive, ...seen].join();
        });
        must(left === '0,refused,refused,refused', `workers that stay, and what became of three builds: ${left}`);
    },
    async a_browser_without_webgl_2_is_told_why() {
        if (page) await page.close();
        page = await newPage();
        await page.evaluateOnNewDocument('HTMLCanvasElement.prototype.getContext = () => null');
        await page.goto(`file://${folder}/product.html`);
        await until('getComputedStyle(document.getElementById("instead")).display === "block"');
        must(await page.evaluate('document.querySelector("#instead img").naturalWidth > 100'), 'the picture is missing');
    }
};

/* In another browser by another renderer. */
tests.index_and_product_load_in_firefox = async () => {
    wanted = 'firefox';
    await open('index.html');
    must(await page.evaluate('[...document.images].every((i) => i.naturalWidth > 100)'), 'a picture is missing');
    must(said.length === 0, `the console has: ${said.join(' | ')}`);
    await open('product.html');
    await until('state.ready');
    await page.evaluate('SIDES.splice(0, 3, [16, 64]), FULL = 1, adapt = () => {}, load("builtin:knot")');
    await built();
    await changed();
    await settled(1);
    const shown = await picture();
    const d = difference(shown, twin(native, ['builtin:knot', 'builtin:sky', shown.width, shown.height, 1, 16, 64, 0, `${scratch}/native.png`]));
    must(await message() === '' && said.length === 0, `it says: ${await message()} ${said.join(' | ')}`);
    must(d.mean < 0.5 && d.far < 0.005, `mean difference ${d.mean}, share of pixels beyond 8 ${d.far}`);
};
for (const name of ['room', 'game', 'sky', 'filter'])
    tests[`${name}_is_the_native_one_in_firefox`] = async () => {
        wanted = 'firefox';
        await scene(name, { mean: 1, far: 0.01 });
    };
tests.three_js_draws_with_our_shadows_in_firefox = async () => {
    wanted = 'firefox';
    await three();
};

/* Modules may not be loaded from the disk: a plain file server, for this machine alone. */
const types = { html: 'text/html', mjs: 'text/javascript', js: 'text/javascript', css: 'text/css', wasm: 'application/wasm', png: 'image/png' };
async function serve(headers) {
    const server = createServer((request, response) => {
        const file = `${folder}/${request.url.split('?')[0].replace(/\.\./g, '')}`;
        try {
            const bytes = readFileSync(file);
            response.writeHead(200, { 'content-type': types[file.split('.').pop()] || 'application/octet-stream', ...headers });
            response.end(bytes);
        } catch {
            response.writeHead(404);
            response.end();
        }
    });
    await new Promise((done) => server.listen(0, '127.0.0.1', done));
    return server;
}
const servers = [await serve({}), await serve({ 'cross-origin-opener-policy': 'same-origin', 'cross-origin-embedder-policy': 'require-corp' })];
const [served, isolated] = servers.map((server) => `http://127.0.0.1:${server.address().port}`);
if (!existsSync(`${folder}/three.html`)) {
    if (process.env.CI) throw new Error('three.html is missing');
    console.log('skip: three.html was left out');
    delete tests.three_js_draws_with_our_shadows;
    delete tests.the_module_refuses_what_is_wrong_by_name;
}

if (!process.env.DISPLAY || !existsSync(browsers.firefox.executablePath)) {
    if (process.env.CI) throw new Error('firefox-esr or a display for it (xvfb-run) is missing');
    console.log('skip: no pages in Firefox: firefox-esr or a display for it (xvfb-run) is missing');
    for (const name of Object.keys(tests)) if (/_in_firefox$/.test(name)) delete tests[name];
}

/* Tests from one on that opens a page to the last that goes on with it: [[name, ...], ...]. */
function groups(names) {
    const list = [];
    for (const name of names)
        if (!list.length || /\b(open|scene|newPage)\(/.test(tests[name].toString())) list.push([name]);
        else list.at(-1).push(name);
    return list;
}

/* Seconds of processors that this program and what it has started have taken so far: what else runs on a machine changes
   the time of a test by a factor, and this by little. Linux alone. */
const fields = (id) => readFileSync(`/proc/${id}/stat`, 'latin1').replace(/.*\) /, '').split(' ').map(Number);
const reaped = () => { try { const f = fields('self'); return f[13] + f[14]; } catch { return 0; } };
const taken = new Map();
let twins = 0;
function work() {
    const all = new Map();
    try {
        for (const id of readdirSync('/proc').filter((n) => /^\d+$/.test(n)))
            try { all.set(+id, fields(id)); } catch { /* it ended just now */ }
    } catch { return 0; }
    for (const [id, f] of all) {
        let up = id;
        while (up && up !== process.pid) up = all.get(up)?.[1];
        if (up) taken.set(id, f[11] + f[12]);
    }
    return ([...taken.values()].reduce((a, b) => a + b, 0) + twins) / 100;
}

/* Runs the tests of a group. A browser that dies says nothing about a page: the group is begun once more with a new one. */
async function run(group) {
    const begun = new Set(), passed = new Set();
    for (const last of [false, true]) {
        for (const name of group) {
            if (!begun.has(name)) console.log(`[ RUN      ] ${name}`);
            begun.add(name);
            const started = performance.now(), before = work();
            try {
                await tests[name]();
                console.log(`${name}: ${((performance.now() - started) / 1000).toFixed(1)} s, of processors ${(work() - before).toFixed(1)} s`);
                if (!passed.has(name)) console.log(`[       OK ] ${name}`);
                passed.add(name);
            } catch (error) {
                console.log(error.message);
                await wait(1000);                   // what died may be told after what it broke
                if (lost && !last) break;
                console.log(`[  FAILED  ] ${name}`);
                bad.push(name);
            }
        }
        if (!lost) return;
        console.log(`${lost}${last ? '' : '; once more'}`);
        await closeBrowser();
    }
}

const names = Object.keys(tests).filter((name) => new RegExp(process.env.ONLY || '').test(name)), bad = [];
console.log(`[==========] Running ${names.length} test(s).`);
for (const group of groups(names)) await run(group);
await closeBrowser();
for (const server of servers) server.close();
console.log(`[==========] ${names.length} test(s) run.`);
process.exit(bad.length ? 1 : 0);
