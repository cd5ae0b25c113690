/* browsers.mjs - pages of tests in browsers, driven by puppeteer-core: node browsers.mjs COUNT NAME=PAGE.html... NAME says what
   draws: chromium is Chromium by SwiftShader, angle_gl and angle_gles are Chromium by this machine's OpenGL and OpenGL ES, and
   firefox is Firefox, which takes OpenGL. Runs COUNT browsers side by side, each of which takes the next page when it has shown
   one, of its own kind while there are any. Writes what a page has printed to PAGE.html.dom, the console to PAGE.html.log, and says
   how long each took, and how much of that processors did. A browser's start takes longer than most tests, so it shows many; if it
   dies, its page gets a new one, once. */
import puppeteer from 'puppeteer-core';
import { readdirSync, readFileSync, writeFileSync } from 'node:fs';
import { resolve } from 'node:path';

const limit = 1000 * (process.env.TIMEOUT || 900);
const count = +process.argv[2];
const waiting = process.argv.slice(3).map((text) => {
    const at = text.indexOf('=');
    return { kind: text.slice(0, at), file: text.slice(at + 1) };
});
const chromium = (headless, ...args) => ({ executablePath: process.env.CHROMIUM || '/usr/bin/chromium', headless,
    protocolTimeout: limit, args: ['--no-sandbox', '--disable-dev-shm-usage', ...args] });
const options = {
    chromium: chromium(true, '--use-angle=swiftshader', '--enable-unsafe-swiftshader'),
    angle_gl: chromium(false, '--use-gl=angle', '--use-angle=gl', '--ignore-gpu-blocklist'),
    angle_gles: chromium(false, '--use-gl=angle', '--use-angle=gles', '--ignore-gpu-blocklist'),
    firefox: { browser: 'firefox', executablePath: process.env.FIREFOX || '/usr/bin/firefox-esr', headless: false, protocolTimeout: limit,
        extraPrefsFirefox: { 'webgl.force-enabled': true, 'gfx.webrender.software': true, 'webgl.out-of-process': false } }
};
const shown = new Map();                            // how many browsers of each kind there are

/* The next page for who has a browser of this kind: of the same, then of one that nobody has. */
function next(kind) {
    const find = (good) => waiting.findIndex((w) => good(w.kind));
    let at = find((k) => k === kind);
    if (at < 0) at = find((k) => !shown.get(k));
    const page = waiting.splice(Math.max(0, at), 1)[0];
    if (page && page.kind !== kind) {
        if (kind) shown.set(kind, shown.get(kind) - 1);
        shown.set(page.kind, (shown.get(page.kind) || 0) + 1);
    }
    return page;
}

/* Hundredths of seconds of processors that each process of a browser has taken, by its id. Linux alone. */
function work(browser) {
    const all = new Map(), taken = new Map(), root = browser?.process()?.pid;
    try {
        for (const id of readdirSync('/proc').filter((n) => /^\d+$/.test(n)))
            try { all.set(+id, readFileSync(`/proc/${id}/stat`, 'latin1').replace(/.*\) /, '').split(' ').map(Number)); } catch { /* it ended just now */ }
    } catch { return taken; }
    for (const [id, f] of all) {
        let up = id;
        while (up && up !== root) up = all.get(up)?.[1];
        if (up) taken.set(id, f[11] + f[12]);
    }
    return taken;
}

/* over: called when the page has shown its end, and is still there. */
async function show(browser, file, said, over) {
    const page = await browser.newPage();
    page.on('console', (m) => said.push(`CONSOLE ${m.text()}`));
    page.on('pageerror', (e) => said.push(`CONSOLE ${e.message}`));
    await page.goto(`file://${resolve(file)}`, { timeout: limit });
    await page.waitForFunction(() => /^exit \d+/m.test(document.body.textContent), { timeout: limit, polling: 200 });
    const text = await page.evaluate(() => document.body.textContent);
    over();
    await page.close();
    return text;
}

async function take_pages() {
    let browser, has;
    const end = async () => { await browser?.close().catch(() => {}); browser = undefined; };
    for (let page = next(has); page; page = next(has)) {
        const { kind, file } = page, started = performance.now();
        let said, text = '', before, spent = 0;
        if (kind !== has) await end();
        has = kind;
        for (let again = 1; again >= 0 && !text; again--) {
            said = [];
            try {
                browser ||= await puppeteer.launch(options[kind]);
                before = work(browser);
                text = await show(browser, file, said, () => { for (const [id, t] of work(browser)) spent += t - (before.get(id) || 0); });
            } catch (error) {
                said.push(`CONSOLE ${error.message}`);
                await end();
            }
        }
        writeFileSync(`${file}.dom`, text);
        writeFileSync(`${file}.log`, said.join('\n') + '\n');
        console.log(`${file}: ${((performance.now() - started) / 1000).toFixed(1)} s, of processors ${(spent / 100).toFixed(1)} s`);
    }
    await end();
}

await Promise.all(Array.from({ length: count }, take_pages));
