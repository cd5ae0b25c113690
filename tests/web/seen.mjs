// seen.mjs - what bake writes, seen by others: Khronos' glTF validator finds no error that the model did not have, and
// three.js shows it in Chromium as it should look. Pairs of files, before and after, come as arguments behind the folder
// for pictures; each pair becomes STEM.png, before on the left, after on the right. Called by tests/scripts/seen.sh.
import { readFileSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { basename, extname, join, resolve } from 'node:path';
import { createRequire } from 'node:module';
import puppeteer from 'puppeteer-core';

const require = createRequire(import.meta.url);
const validator = require('gltf-validator');
const [out, ...files] = process.argv.slice(2);
const root = new URL('.', import.meta.url).pathname;
const page_text = `<!doctype html><style>body{margin:0;background:#fff;display:flex}</style><script type="importmap">{"imports":{
"three":"/node_modules/three/build/three.module.js","three/addons/":"/node_modules/three/examples/jsm/"}}</script>
<script type="module">
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
async function show(url, x) {
    const gltf = await new GLTFLoader().loadAsync(url), found = { colors: 0, images: 0, lights: 0, meshes: 0, mean: 0 };
    const scene = new THREE.Scene();
    scene.background = new THREE.Color(0xffffff);
    scene.add(gltf.scene);
    gltf.scene.traverse(o => {
        found.lights += o.isLight ? 1 : 0;
        if (!o.isMesh) return;
        found.meshes++;
        found.colors += o.material.vertexColors ? 1 : 0;
        found.images += o.material.aoMap ? 1 : 0;
    });
    const box = new THREE.Box3().setFromObject(gltf.scene), sphere = box.getBoundingSphere(new THREE.Sphere());
    if (!found.lights) scene.add(new THREE.AmbientLight(0xffffff, 3));
    const camera = new THREE.PerspectiveCamera(35, 1, sphere.radius / 100, sphere.radius * 10 + 1);
    camera.position.copy(sphere.center).add(new THREE.Vector3(0.5, 0.4, 0.87).normalize().multiplyScalar(3.4 * sphere.radius));
    camera.lookAt(sphere.center);
    const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    renderer.setSize(480, 480);
    document.body.append(renderer.domElement);
    renderer.render(scene, camera);
    return found;
}
const all = [];
for (const url of ['/before.glb', '/after.glb']) all.push(await show(url));
window.found = all;
</script>`;

let pair = [];
const server = createServer((request, answer) => {
    const path = request.url.split('?')[0], types = { '.js': 'text/javascript', '.glb': 'model/gltf-binary' };
    try {
        const body = path === '/' ? page_text : path === '/before.glb' ? readFileSync(pair[0])
            : path === '/after.glb' ? readFileSync(pair[1]) : readFileSync(resolve(join(root, path)));
        answer.writeHead(200, { 'content-type': path === '/' ? 'text/html' : types[extname(path)] || 'text/plain' });
        answer.end(body);
    } catch { answer.writeHead(404); answer.end(); }
}).listen(0, '127.0.0.1');

const errors_of = async file => (await validator.validateBytes(new Uint8Array(readFileSync(file)), { maxIssues: 0 })).issues.numErrors;
const browser = await puppeteer.launch({ executablePath: process.env.CHROMIUM || '/usr/bin/chromium', headless: true,
    args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-dev-shm-usage'] });
let failed = 0;
for (let i = 0; i + 1 < files.length; i += 2) {
    pair = [files[i], files[i + 1]];
    const name = basename(pair[1], '.glb'), page = await browser.newPage(), said = [];
    page.on('pageerror', e => said.push(String(e)));
    page.on('console', m => { if (m.type() === 'error' && !m.text().includes('favicon')) said.push(m.text()); });
    await page.setViewport({ width: 960, height: 480 });
    const errors = [await errors_of(pair[0]), await errors_of(pair[1])];
    await page.goto(`http://127.0.0.1:${server.address().port}/`);
    await page.waitForFunction('window.found', { timeout: 120000 }).catch(e => said.push(String(e)));
    const found = await page.evaluate('window.found');
    await page.screenshot({ path: join(out, `${name}.png`) });
    await page.close();
    const after = found && found[1];
    const gained = after && (after.colors + after.images > found[0].colors + found[0].images || after.lights > found[0].lights);
    const good = errors[1] <= errors[0] && gained && after.meshes >= found[0].meshes && said.every(s => s.includes('favicon') || s.includes('404'));
    console.log(`  ${good ? 'passed' : 'FAILED'}: ${name}: ${errors[1]} errors of ${errors[0]}, ${JSON.stringify(after)} ${good ? '' : said.join(' ')}`);
    failed += good ? 0 : 1;
}
await browser.close();
server.close();
process.exit(failed ? 1 : 0);
