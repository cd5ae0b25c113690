/* firefox.mjs - pages of tests in Firefox, one after the other, driven by puppeteer-core over WebDriver BiDi: node firefox.mjs
   PAGE.html... Writes what a page has printed to PAGE.html.dom, the console to PAGE.html.log, and says how long each took.
   All are tabs of one browser, whose start takes longer than most tests; if it dies, the page that it had
   and those after it get a new one, once each. */
import puppeteer from 'puppeteer-core';
import { writeFileSync } from 'node:fs';
import { resolve } from 'node:path';

const limit = 1000 * (process.env.TIMEOUT || 300);
let browser;

async function launch() {
    browser = await puppeteer.launch({
        browser: 'firefox', executablePath: process.env.FIREFOX || '/usr/bin/firefox-esr', headless: false, protocolTimeout: limit,
        extraPrefsFirefox: { 'webgl.force-enabled': true, 'gfx.webrender.software': true, 'webgl.out-of-process': false }
    });
}

async function show(file, said) {
    const page = await browser.newPage();
    page.on('console', (m) => said.push(`CONSOLE ${m.text()}`));
    page.on('pageerror', (e) => said.push(`CONSOLE ${e.message}`));
    await page.goto(`file://${resolve(file)}`, { timeout: limit });
    await page.waitForFunction(() => /^exit \d+/m.test(document.body.textContent), { timeout: limit, polling: 200 });
    const text = await page.evaluate(() => document.body.textContent);
    await page.close();
    return text;
}

async function run(file) {
    const started = performance.now();
    let said, text = '';
    for (let again = 1; again >= 0 && !text; again--) {
        said = [];
        try {
            if (!browser) await launch();
            text = await show(file, said);
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

for (const file of process.argv.slice(2)) await run(file);
await browser?.close();
