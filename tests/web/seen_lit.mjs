// seen_lit.mjs - what `bake lights` and `bake probes` write, used by three.js in Chromium, and held against numbers:
//   node seen_lit.mjs OUT.png lights MODEL.glb LIGHTS.glb LIGHTS.json
//   node seen_lit.mjs OUT.png probes MODEL.glb PROBES.json PROBES.glsl
// OUT.png has the model before, in even light, on the left, and after on the right. Called by tests/scripts/seen.sh, which copies
// it beside three.js; docs/pictures/bake-lights.png and bake-probes.png are its pictures, by the commands named there.
import { readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { dirname, extname, join, resolve } from 'node:path';
import puppeteer from 'puppeteer-core';

const [out, what, ...files] = process.argv.slice(2);
const root = new URL('.', import.meta.url).pathname;
const page_text = `<!doctype html><style>body{margin:0;background:#fff;display:flex}</style><script type="importmap">{"imports":{
"three":"/node_modules/three/build/three.module.js","three/addons/":"/node_modules/three/examples/jsm/"}}</script>
<script type="module">import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
const SIDE = 480, load = async url => (await new GLTFLoader().loadAsync(url)).scene;
const renderer = new THREE.WebGLRenderer();
renderer.shadowMap.enabled = true;
/* Linear light of a scene, 4 floats a pixel, lowest row first. */
function draw(scene, camera, side = SIDE) {
    const target = new THREE.WebGLRenderTarget(side, side, { type: THREE.FloatType }), light = new Float32Array(4 * side * side);
    renderer.setRenderTarget(target);
    renderer.render(scene, camera);
    renderer.readRenderTargetPixels(target, 0, 0, side, side, light);
    target.dispose();
    return light;
}
/* Light times exposure, cut at 1, as sRGB; of samples * samples values a pixel. */
function show(light, exposure, samples = 1) {
    const canvas = document.createElement('canvas'), n = SIDE * samples;
    canvas.width = canvas.height = SIDE;
    const context = canvas.getContext('2d'), image = context.createImageData(SIDE, SIDE);
    const srgb = x => x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055;
    for (let i = 0; i < SIDE * SIDE; i++)
        for (let k = 0; k < 4; k++) {
            let sum = 0;
            for (let s = 0; s < samples * samples; s++) {
                const x = samples * (i % SIDE) + s % samples, y = n - 1 - (samples * Math.floor(i / SIDE) + Math.floor(s / samples));
                sum += srgb(Math.min(1, Math.max(0, light[4 * (y * n + x) + k] * exposure)));
            }
            image.data[4 * i + k] = k === 3 ? 255 : 255 * sum / samples / samples;
        }
    context.putImageData(image, 0, 0);
    document.body.append(canvas);
}
PAGE
</script>`;

// A model on a white floor. Every light is drawn alone, with its shadow map, and the pictures are added: three.js shades by hundreds
// of lights at once, as the number below has it, but not with as many maps. Each picture is shifted within the pixel, so that edges are smooth.
const lights_page = `
const [model, sky] = [await load('/file0'), await load('/file1')], lights = [];
sky.updateMatrixWorld(true);
sky.traverse(o => { if (o.isDirectionalLight) lights.push(o); });
const floor_of = size => new THREE.Mesh(new THREE.PlaneGeometry(size, size).rotateX(-Math.PI / 2), new THREE.MeshLambertMaterial({ color: 0xffffff }));
const down = new THREE.OrthographicCamera(-1, 1, 1, -1, 0.1, 10), check = new THREE.Scene();
down.position.y = 2;
down.lookAt(0, 0, 0);
check.add(floor_of(4), sky);
const floor = [...draw(check, down, 4).subarray(20, 23)].map(x => x * Math.PI);
check.remove(sky);

const scene = new THREE.Scene(), box = new THREE.Box3().setFromObject(model), ball = box.getBoundingSphere(new THREE.Sphere()), R = ball.radius;
model.traverse(o => {
    if (!o.isMesh) return;
    o.castShadow = o.receiveShadow = true;
    o.material = new THREE.MeshLambertMaterial({ color: o.material.color, vertexColors: o.material.vertexColors, map: o.material.map });
});
const ground = floor_of(40 * R);
ground.position.set(ball.center.x, box.min.y, ball.center.z);
ground.receiveShadow = true;
scene.add(model, ground);
const camera = new THREE.PerspectiveCamera(35, 1, R / 100, 100 * R);
camera.position.copy(ball.center).add(new THREE.Vector3(0.5, 0.5, 0.87).normalize().multiplyScalar(3.6 * R));
camera.lookAt(ball.center);
const even = new THREE.AmbientLight(new THREE.Color().setRGB(...floor), 1), exposure = 0.75 * Math.PI / Math.max(...floor);
const sum = new Float32Array(4 * SIDE * SIDE), before = new Float32Array(sum.length);
scene.add(even);
for (let i = 0; i < 4; i++) {
    camera.setViewOffset(SIDE, SIDE, (i & 1) / 2 - 0.25, (i >> 1) / 2 - 0.25, SIDE, SIDE);
    draw(scene, camera).forEach((x, k) => { before[k] += x / 4; });
}
scene.remove(even);
const one = new THREE.DirectionalLight();
one.castShadow = true;
one.shadow.mapSize.set(1024, 1024);
Object.assign(one.shadow.camera, { left: -2.2 * R, right: 2.2 * R, top: 2.2 * R, bottom: -2.2 * R, near: R / 10, far: 9 * R });
one.shadow.normalBias = R / 150;
scene.add(one, one.target);
one.target.position.copy(ball.center);
let above = 0;
for (const light of lights) {
    const to = new THREE.Vector3().setFromMatrixPosition(light.matrixWorld).sub(new THREE.Vector3().setFromMatrixPosition(light.target.matrixWorld)).normalize();
    if (to.y <= 0) continue;                             // the floor hides it
    const k = above++;
    one.position.copy(ball.center).addScaledVector(to, 4.5 * R);
    one.color.copy(light.color);
    one.intensity = light.intensity;
    camera.setViewOffset(SIDE, SIDE, (k * 0.7548776662) % 1 - 0.5, (k * 0.5698402910) % 1 - 0.5, SIDE, SIDE);
    draw(scene, camera).forEach((x, i) => { sum[i] += x; });
}
show(before, exposure);
show(sum, exposure);
window.found = { floor, lights: lights.length, above };`;

// White spheres in the Cornell box, from one wall to the other, and the box, of the probes' light by probes.glsl alone.
const probes_page = `
const room = await load('/file0'), { probes: file } = await (await fetch('/file1')).json(), glsl = await (await fetch('/file2')).text();
const data = new Float32Array(await (await fetch('/bin')).arrayBuffer());
const table = new THREE.DataTexture(data, file.floats, file.count, THREE.RedFormat, THREE.FloatType);
table.needsUpdate = true;
const vector = v => new THREE.Vector3(...v), step = vector(file.step).length();
const uniforms = { probes: { value: table }, grid: { value: file.grid }, origin: { value: vector(file.origin) },
    step_size: { value: vector(file.step) }, away: { value: 0.2 * step }, side: { value: file.side }, output_of: { value: 0 }, even: { value: new THREE.Vector3() } };
const material = color => new THREE.ShaderMaterial({ glslVersion: THREE.GLSL3, side: THREE.FrontSide, uniforms: { ...uniforms, albedo: { value: color } },
    vertexShader: 'out vec3 p, n; void main() { vec4 q = modelMatrix * vec4(position, 1.0); p = q.xyz; n = mat3(modelMatrix) * normal; gl_Position = projectionMatrix * viewMatrix * q; }',
    fragmentShader: 'precision highp float; precision highp int; precision highp sampler2D; in vec3 p, n; out vec4 color; uniform sampler2D probes; uniform ivec3 grid;'
        + ' uniform vec3 origin, step_size, albedo, even; uniform float away; uniform int side, output_of;\\n' + glsl
        + 'void main() { vec3 m = normalize(n), at = p + away * m; if (output_of == 1) { color = vec4(at, 1.0); return; } if (output_of == 2) { color = vec4(m, 1.0); return; }'
        + ' vec3 e = output_of == 3 ? even : dapple_probe_irradiance(probes, grid, origin, step_size, side, at, m); color = vec4(e * (output_of == 4 ? vec3(1.0) : albedo / 3.14159265), 1.0); }' });
const scene = new THREE.Scene(), box = new THREE.Box3().setFromObject(room), size = box.getSize(new THREE.Vector3()), centre = box.getCenter(new THREE.Vector3());
room.traverse(o => { if (o.isMesh) o.material = o.material.emissiveIntensity > 1 ? new THREE.MeshBasicMaterial({ color: 0xffffff }) : material(o.material.color); });
const spheres = [0, 1, 2, 3, 4].map(i => {
    const mesh = new THREE.Mesh(new THREE.SphereGeometry(0.085 * size.x, 96, 64), material(new THREE.Color(0.8, 0.8, 0.8)));
    mesh.position.set(box.max.x - size.x * (0.12 + 0.19 * i), box.min.y + 0.46 * size.y, box.min.z + 0.22 * size.z);
    return mesh;
});
scene.add(room, ...spheres);
const samples = 2, n = samples * SIDE, camera = new THREE.PerspectiveCamera(38, 1, 0.01 * size.x, 20 * size.x);
camera.position.copy(centre).add(new THREE.Vector3(0, 0, -1.95 * size.z));
camera.lookAt(centre);
camera.updateMatrixWorld();
const pass = i => { uniforms.output_of.value = i; return draw(scene, camera, n); };
const after = pass(0), irradiance = pass(4), places = pass(1), normals = pass(2), light = after.filter((x, i) => i % 4 === 1).sort();
/* Pixels of the spheres' edges that look along +x and -x, and what lies there. */
const sides = spheres.flatMap(s => [0.9, -0.9].map(x => {
    const q = new THREE.Vector3(x, 0, -Math.sqrt(1 - x * x)).multiplyScalar(0.085 * size.x).add(s.position).project(camera);
    const at = 4 * (Math.floor((q.y + 1) / 2 * n) * n + Math.floor((q.x + 1) / 2 * n));
    return { irradiance: [...irradiance.subarray(at, at + 3)], p: [...places.subarray(at, at + 3)], n: [...normals.subarray(at, at + 3)] };
}));
/* Even light of the mean irradiance of what is in the picture. */
const mean = [0, 0, 0];
let lit = 0;
for (let i = 0; i < irradiance.length; i += 4)
    if (Math.abs(Math.hypot(...normals.subarray(i, i + 3)) - 1) < 0.1) {      // not the lamp, which is white
        lit++;
        for (let k = 0; k < 3; k++) mean[k] += irradiance[i + k];
    }
uniforms.even.value.set(...mean.map(x => x / lit));
show(pass(3), 0.9 / light[Math.floor(0.985 * light.length)], samples);
show(after, 0.9 / light[Math.floor(0.985 * light.length)], samples);
window.found = { sides };`;

/* ---- docs/probes.md in JavaScript's doubles ---- */

function harmonics([x, y, z]) {
    return [0.282095, 0.488603 * y, 0.488603 * z, 0.488603 * x, 1.092548 * x * y, 1.092548 * y * z, 0.315392 * (3 * z * z - 1), 1.092548 * x * z,
        0.546274 * (x * x - y * y)];
}
function distances(data, first, side, d) {
    const length = Math.abs(d[0]) + Math.abs(d[1]) + Math.abs(d[2]), sign = v => v < 0 ? -1 : 1, [x, y, z] = d.map(v => v / length);
    const map = z < 0 ? [(1 - Math.abs(y)) * sign(x), (1 - Math.abs(x)) * sign(y)] : [x, y];
    const [u, v] = map.map(c => Math.min(side - 1, Math.max(0, (0.5 * c + 0.5) * side - 0.5)));
    let mean = 0, square = 0;
    for (let j = 0; j < side; j++)
        for (let i = 0; i < side; i++) {
            const weight = Math.max(0, 1 - Math.abs(u - i)) * Math.max(0, 1 - Math.abs(v - j)), at = first + 27 + 2 * (j * side + i);
            mean += weight * data[at];
            square += weight * data[at + 1];
        }
    return [mean, square];
}
function irradiance_of(file, data, p, n) {
    const sum = [0, 0, 0], basis = harmonics(n);
    let weights = 0;
    file.positions.forEach((at, probe) => {
        const near = at.reduce((product, a, k) => {
            const x = Math.min(file.origin[k] + (file.grid[k] - 1) * file.step[k], Math.max(file.origin[k], p[k]));
            return product * Math.max(0, 1 - Math.abs(x - a) / file.step[k]);
        }, 1);
        if (near <= 0) return;
        const to = p.map((c, k) => c - at[k]), away = Math.hypot(...to), facing = 0.5 - 0.5 * to.reduce((s, c, k) => s + c * n[k], 0) / away;
        const [mean, square] = distances(data, probe * file.floats, file.side, to);
        const variance = Math.max(square - mean * mean, 1e-6 + 1e-3 * mean * mean), over = Math.max(away - mean, 0);
        const weight = Math.max(near, 1e-4) * (facing * facing + 0.1) * Math.max((variance / (variance + over * over)) ** 3, 0.01);
        weights += weight;
        for (let k = 0; k < 3; k++)
            sum[k] += weight * Math.max(0, basis.reduce((s, b, j) => s + b * data[probe * file.floats + 3 * j + k], 0));
    });
    return sum.map(s => s / weights);
}

/* ---- what must hold ---- */

const apart = (a, b) => Math.max(...a.map((x, k) => Math.abs(x - b[k]))) / Math.max(...b);
const short = list => list.map(x => x.toPrecision(4)).join(', ');
const checks = {
    lights(found) {
        const listed = JSON.parse(readFileSync(files[2])).frames[0].lights, sum = [0, 0, 0];
        for (const l of listed) for (let k = 0; k < 3; k++) sum[k] += l.irradiance[k] * Math.max(0, l.direction[1]);
        const error = apart(found.floor, sum);
        return [found.lights === listed.length && error < 0.01,
            `${found.lights} lights of ${listed.length}, ${found.above} of them above the floor, whose irradiance is ${short(found.floor)}; E cos adds up to ${short(sum)}`];
    },
    probes({ sides }) {
        const file = JSON.parse(readFileSync(files[1])).probes, bytes = readFileSync(join(dirname(files[1]), file.bin));
        const data = new Float32Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength));
        const worst = Math.max(...sides.map(s => apart(s.irradiance, irradiance_of(file, data, s.p, s.n))));
        const red = sides.map(s => s.irradiance[0] / s.irradiance[1]);
        const good = red.every((r, i) => i % 2 || r > 1.02 * red[i + 1]), normals = sides.every((s, i) => (i % 2 ? -1 : 1) * s.n[0] > 0.85);
        return [good && normals && worst < 1e-4, `red over green of 5 spheres, towards the red wall and the green one: ${short(red)}; ${worst.toExponential(1)} from docs/probes.md`];
    }
};
const server = createServer((request, answer) => {
    const path = request.url.split('?')[0], numbered = /^\/file(\d)$/.exec(path);
    try {
        const body = path === '/' ? page_text.replace('PAGE', () => what === 'lights' ? lights_page : probes_page) : numbered ? readFileSync(files[numbered[1]])
            : path === '/bin' ? readFileSync(join(dirname(files[1]), JSON.parse(readFileSync(files[1])).probes.bin)) : readFileSync(resolve(join(root, path)));
        answer.writeHead(200, { 'content-type': path === '/' ? 'text/html' : extname(path) === '.js' ? 'text/javascript' : 'application/octet-stream' });
        answer.end(body);
    } catch { answer.writeHead(404); answer.end(); }
}).listen(0, '127.0.0.1');
const browser = await puppeteer.launch({ executablePath: process.env.CHROMIUM || '/usr/bin/chromium', headless: true, protocolTimeout: 300000,
    args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-dev-shm-usage'] });
const page = await browser.newPage(), said = [];
page.on('pageerror', e => said.push(String(e)));
page.on('console', m => { if (m.type() === 'error' && !m.location().url.endsWith('favicon.ico')) said.push(m.text()); });
await page.setViewport({ width: 960, height: 480 });
await page.goto(`http://127.0.0.1:${server.address().port}/`);
const stop = Date.now() + 280000;
while (!await page.evaluate('window.found') && !said.length && Date.now() < stop) await new Promise(done => setTimeout(done, 200));
const found = await page.evaluate('window.found'), [good, text] = found && !said.length ? checks[what](found) : [false, said.join(' ') || 'no picture came'];
await page.screenshot({ path: out });
await browser.close();
server.close();
console.log(`  ${good ? 'passed' : 'FAILED'}: ${what} in three.js: ${text}`);
process.exit(good ? 0 : 1);
