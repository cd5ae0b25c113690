/* firefox.mjs - pages of tests in Firefox, one after the other, driven by puppeteer-core over WebDriver BiDi: node firefox.mjs
   PAGE.html... Writes what a page has printed to PAGE.html.dom and the console to PAGE.html.log, as Chromium's --dump-dom and
   --enable-logging do for tools/check-browser. A browser of its own for each, so that one that dies takes no others with it. */
import puppeteer from 'puppeteer-core';
import { writeFileSync } from 'node:fs';
import { resolve } from 'node:path';

const limit = 1000 * (process.env.TIMEOUT || 300);

async function run(file) {
    const said = [];
    const browser = await puppeteer.launch({
        browser: 'firefox', executablePath: process.env.FIREFOX || '/usr/bin/firefox-esr', headless: false, protocolTimeout: limit,
        extraPrefsFirefox: { 'webgl.force-enabled': true, 'gfx.webrender.software': true, 'webgl.out-of-process': false }
    });
    try {
        const page = await browser.newPage();
        page.on('console', (m) => said.push(`CONSOLE ${m.text()}`));
        page.on('pageerror', (e) => said.push(`CONSOLE ${e.message}`));
        await page.goto(`file://${resolve(file)}`, { timeout: limit });
        await page.waitForFunction(() => /^exit \d+/m.test(document.body.textContent), { timeout: limit, polling: 200 });
        writeFileSync(`${file}.dom`, await page.evaluate(() => document.body.textContent));
    } catch (error) {
        said.push(`CONSOLE ${error.message}`);
        writeFileSync(`${file}.dom`, '');
    }
    writeFileSync(`${file}.log`, said.join('\n') + '\n');
    await browser.close();
}

for (const file of process.argv.slice(2)) await run(file);
