/* three-page.mjs - three.js with a sun whose soft shadow comes from coherent shadow maps. What it takes: the library's GLSL
   before three's own, one factor in three's loop over directional lights, and the maps bound before each frame. */
import * as THREE from 'three';
import { attach, build } from './dapple.mjs';

const element = (id) => document.getElementById(id);
const canvas = element('picture');
const sun = { azimuth: 0.7, height: 0.9 };

/* ---- a scene of three.js, which knows nothing of us ---- */

const renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
const scene = new THREE.Scene();
const camera = new THREE.PerspectiveCamera(34, 1, 0.1, 60);
const knot = new THREE.Mesh(new THREE.TorusKnotGeometry(1, 0.32, 160, 24), new THREE.MeshStandardMaterial({ color: 0xc98a5a, roughness: 0.55 }));
const ground = new THREE.Mesh(new THREE.PlaneGeometry(40, 40), new THREE.MeshStandardMaterial({ color: 0xb8b8b0, roughness: 0.9 }));
const light = new THREE.DirectionalLight(0xfff2e0, 3);
scene.background = new THREE.Color(0x2b3038);
scene.add(knot, ground, light, light.target, new THREE.HemisphereLight(0xa8c4e8, 0x6b6258, 0.9));
knot.position.y = 1.55;
ground.rotation.x = -Math.PI / 2;
camera.position.set(4.6, 3.4, 5.4);
camera.lookAt(0, 1.1, 0);

/* ---- our shadow in its materials ---- */

/* entity: the instance that the material's points lie on, from 1; 0 = none. */
function addShadow(material, glsl, entity, uniforms) {
    material.onBeforeCompile = (shader) => {
        Object.assign(shader.uniforms, uniforms);
        shader.vertexShader = 'out vec3 dapplePoint;\n' + shader.vertexShader.replace('#include <project_vertex>',
            '#include <project_vertex>\ndapplePoint = (modelMatrix * vec4(transformed, 1.0)).xyz;');
        shader.fragmentShader = shader.fragmentShader.replace('#include <common>', glsl + `
in vec3 dapplePoint;
uniform float dappleWidth;
uniform vec3 dappleSun;
/* How much of a disc in the sky is seen, by a spiral of directions, turned pixel by pixel. Roulette takes one of the maps about
   each direction at random, which hides that there are few of them. */
float dappleSeen(vec3 normal)
{
    cohsm_query ask = cohsm_ask(COHSM_LIGHT_DIRECTION, COHSM_FILTER_ROULETTE, 1.0);
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    ask.seed = pixel.y * 8192u + pixel.x;
    vec3 a = normalize(cross(dappleSun, abs(dappleSun.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0)));
    vec3 b = cross(dappleSun, a);
    float turn = 6.2831853 * fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))), seen = 0.0;
    for (int i = 0; i < 24; i++) {
        float r = dappleWidth * sqrt((float(i) + 0.5) / 24.0), w = 2.3999632 * float(i) + turn;
        ask.id = uint(i);
        seen += csm_visible(${entity}u, ask, dapplePoint + 0.02 * normal, normalize(dappleSun + r * (cos(w) * a + sin(w) * b)));
    }
    return seen / 24.0;
}
#include <common>`).replace('#include <lights_fragment_begin>', THREE.ShaderChunk.lights_fragment_begin.replace(
            'getDirectionalLightInfo( directionalLight, directLight );',
            'getDirectionalLightInfo( directionalLight, directLight );\n' +
            'directLight.color *= dappleSeen(inverseTransformDirection(geometryNormal, viewMatrix));'));
    };
}

function place(maps) {
    knot.updateMatrixWorld();
    maps.place([{ block: 0, matrix: knot.matrixWorld.elements }]);
}

/* Gives the programs that three.js has linked our slots. A change of lights or materials makes other programs: compile and
   call this again then. */
function setSlots(dapple, materials) {
    for (const material of materials) {
        const linked = renderer.properties.get(material).currentProgram;
        if (linked && !linked.dapple) {
            dapple.setSlots(linked.program);
            linked.dapple = true;
        }
    }
    renderer.resetState();
}

function resize() {
    const width = canvas.clientWidth, height = canvas.clientHeight;
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
}

async function start() {
    const uniforms = { dappleWidth: { value: 0.1 }, dappleSun: { value: new THREE.Vector3(0, 1, 0) } };
    const mesh = { positions: knot.geometry.attributes.position.array, indices: knot.geometry.index.array };
    element('work').style.display = 'flex';
    const began = performance.now();
    const side = +(/^#side=(\d+)$/.exec(location.hash)?.[1] ?? 64);        // a name with #side=24 is built sooner, for tests
    let dapple = null, maps, block = null, dirty = true, drag = null, turn = 0;
    /* On a context that is new: the block goes to it, and programs get our slots before they draw. What a context gets that is
       lost meanwhile is void; the next one is given all of it anew. */
    const take = async () => {
        const mine = ++turn, gl = renderer.getContext(), lost = () => mine !== turn || gl.isContextLost();
        if (lost()) return;
        let attached = null;
        try {
            attached = await attach(gl);
            if (lost()) return attached.free({ lost: true });
            shade(attached);
        } catch (error) {
            if (!lost()) throw error;
            if (attached) attached.free({ lost: true });
        }
    };
    const shade = (attached) => {
        maps = attached.maps([block]);
        place(maps);
        const glsl = attached.glsl({ defines: `${maps.defines} COHSM_ONE_LIGHT=0 COHSM_ONE_FILTER=2` });    // as it asks
        addShadow(knot.material, glsl, 1, uniforms);
        addShadow(ground.material, glsl, 0, uniforms);
        renderer.resetState();
        renderer.compile(scene, camera);            // links the programs
        setSlots(attached, [knot.material, ground.material]);
        dapple = attached;
        dirty = true;
    };
    canvas.addEventListener('webglcontextlost', () => {         // three.js does its part itself
        turn++;
        if (dapple) dapple.free({ lost: true });
        dapple = null;
    });
    canvas.addEventListener('webglcontextrestored', () => { if (block) take().catch(fail); });
    block = await build(mesh, { side, mapSide: 128, onProgress: (f) => { element('progress').value = f; } });
    element('work').style.display = 'none';
    element('facts').textContent = `${side} x ${side} maps, ${(block.length / 1e6).toFixed(1)} MB, built in ${((performance.now() - began) / 1000).toFixed(1)} s`;
    await take();
    const draw = () => {
        resize();
        light.position.set(Math.cos(sun.azimuth) * Math.cos(sun.height), Math.sin(sun.height), Math.sin(sun.azimuth) * Math.cos(sun.height)).multiplyScalar(10);
        uniforms.dappleSun.value.copy(light.position).normalize();
        uniforms.dappleWidth.value = Math.tan(element('width').value * Math.PI / 360);
        maps.bind();
        renderer.resetState();
        renderer.render(scene, camera);
        window.dappleFrames = (window.dappleFrames || 0) + 1;
    };
    const loop = () => {
        requestAnimationFrame(loop);
        if (dirty && dapple && !renderer.getContext().isContextLost()) { dirty = false; draw(); }
    };
    canvas.addEventListener('pointerdown', (e) => { drag = [e.clientX, e.clientY]; canvas.setPointerCapture(e.pointerId); });
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, () => { drag = null; });
    const turnSun = (azimuth, height) => {
        sun.azimuth += azimuth;
        sun.height = Math.min(1.5, Math.max(0.15, sun.height + height));
        dirty = true;
    };
    canvas.addEventListener('pointermove', (e) => {
        if (!drag) return;
        turnSun(3 * (e.clientX - drag[0]) / canvas.clientHeight, -2 * (e.clientY - drag[1]) / canvas.clientHeight);
        drag = [e.clientX, e.clientY];
    });
    const arrows = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
    canvas.addEventListener('keydown', (e) => {
        if (e.ctrlKey || e.altKey || e.metaKey || !arrows[e.key]) return;
        turnSun(...arrows[e.key]);
        e.preventDefault();
    });
    element('width').addEventListener('input', () => { dirty = true; });
    window.addEventListener('resize', () => { dirty = true; });
    window.dapplePage = { sun, redraw: () => { dirty = true; } };      // for tests
    loop();
}

function fail(error) {
    element('message').textContent = error.message;
    element('message').classList.add('shown');
}

start().catch(fail);
