/* browsers.mjs - pages of tests in a browser, driven by puppeteer-core: node browsers.mjs NAME COUNT PAGE.html... NAME says what
   draws: chromium is Chromium by SwiftShader, angle_gl and angle_gles are Chromium by this machine's OpenGL and OpenGL ES, and
   firefox is Firefox, which takes OpenGL. Runs COUNT browsers side by side, each of which takes the next page when it has shown
   one. Writes what a page has printed to PAGE.html.dom, the console to PAGE.html.log, and says how long each took. A browser's
   start takes longer than most tests, so it shows many; if it dies, its page gets a new one, once. */
import puppeteer from 'puppeteer-core';
import { writeFileSync } from 'node:fs';
import { resolve } from 'node:path';

const limit = 1000 * (process.env.TIMEOUT || 900);
const [name, count, ...files] = process.argv.slice(2);
const chromium = (headless, ...args) => ({ executablePath: process.env.CHROMIUM || '/usr/bin/chromium', headless,
    protocolTimeout: limit, args: ['--no-sandbox', '--disable-dev-shm-usage', ...args] });
const options = {
    chromium: chromium(true, '--use-angle=swiftshader', '--enable-unsafe-swiftshader'),
    angle_gl: chromium(false, '--use-gl=angle', '--use-angle=gl', '--ignore-gpu-blocklist'),
    angle_gles: chromium(false, '--use-gl=angle', '--use-angle=gles', '--ignore-gpu-blocklist'),
    firefox: { browser: 'firefox', executablePath: process.env.FIREFOX || '/usr/bin/firefox-esr', headless: false, protocolTimeout: limit,
        extraPrefsFirefox: { 'webgl.force-enabled': true, 'gfx.webrender.software': true, 'webgl.out-of-process': false } }
}[name];

async function show(browser, file, said) {
    const page = await browser.newPage();
    page.on('console', (m) => said.push(`CONSOLE ${m.text()}`));
    page.on('pageerror', (e) => said.push(`CONSOLE ${e.message}`));
    await page.goto(`file://${resolve(file)}`, { timeout: limit });
    await page.waitForFunction(() => /^exit \d+/m.test(document.body.textContent), { timeout: limit, polling: 200 });
    const text = await page.evaluate(() => document.body.textContent);
    await page.close();
    return text;
}

async function take_pages() {
    let browser;
    for (let file = files.shift(); file; file = files.shift()) {
        const started = performance.now();
        let said, text = '';
        for (let again = 1; again >= 0 && !text; again--) {
            said = [];
            try {
                browser ||= await puppeteer.launch(options);
                text = await show(browser, file, said);
            } catch (error) {
                said.push(`CONSOLE ${error.message}`);
                await browser?.close().catch(() => {});
                browser = undefined;
            }
        }
        writeFileSync(`${file}.dom`, text);
        writeFileSync(`${file}.log`, said.join('\n') + '\n');
        console.log(`${file}: ${((performance.now() - started) / 1000).toFixed(0)} s`);
    }
    await browser?.close();
}

await Promise.all(Array.from({ length: +count }, take_pages));
