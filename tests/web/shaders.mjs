/* shaders.mjs - node shaders.mjs FOLDER: what Chromium's software renderer takes to compile each of csm's programs, whose
   texts are in FOLDER (build/tools/glsl FOLDER). Prints as cmocka does, for tools/run-tests.

   SwiftShader compiles a program when something is first drawn by it, in a process of its own, so that the seconds of
   processors which that process takes for linking and for one pixel are what is held: at most 2. A program that takes more
   is timed again, up to three times, beside a yardstick, another program, and may take as many times 2 seconds as that one
   takes YARDSTICK: a slow machine is no slow shader. */
import puppeteer from 'puppeteer-core';
import { readdirSync, readFileSync } from 'node:fs';

/* The yardstick's seconds on two cores of a Xeon with a load of 4. */
const folder = process.argv[2], LIMIT = 2, YARDSTICK = 0.55;

/* Without a branch or a loop. */
const yardstick = `#version 300 es
precision highp float;
uniform highp sampler2D from;
out vec4 result;
void main()
{
    vec4 a = texelFetch(from, ivec2(0), 0), b = a.wzyx;
${Array.from({ length: 400 }, (_, i) => `    a = a * b.wxyz + ${1 + i}.5; b = sqrt(abs(b - a.yzwx)) * ${1 + i % 7}.25;`).join('\n')}
    result = a + b;
}
`;

const text = (name) => readFileSync(`${folder}/${name}`, 'utf8');
const names = readdirSync(folder).filter((name) => /^csm_.*-300es\.frag$/.test(name));
const screen = text('screen-0-300es.vert');
/* The vertex shader of a program is the one of its name, of its first set of defines, or that of pictures. */
function vertexOf(name) {
    const own = [name.replace('.frag', '.vert'), name.replace(/-\d+-300es\.frag/, '-0-300es.vert')].find((n) => readdirSync(folder).includes(n));
    return own ? text(own) : screen;
}

/* Seconds of processors that the browser's process for graphics has taken. */
const fields = (id) => readFileSync(`/proc/${id}/stat`, 'latin1').replace(/.*\) /, '').split(' ').map(Number);
function taken() {
    for (const id of readdirSync('/proc').filter((n) => /^\d+$/.test(n)))
        try {
            let up = +id;
            if (!/--type=gpu-process/.test(readFileSync(`/proc/${id}/cmdline`, 'latin1'))) continue;
            while (up > 1 && up !== process.pid) up = fields(up)[1];
            if (up === process.pid) return (fields(id)[11] + fields(id)[12]) / 100;
        } catch { /* it ended just now */ }
    throw new Error('no process for graphics was found');
}

/* Runs in the page: links the texts and draws one pixel with them, from textures and blocks that hold zeros. */
function draw(vertex, fragment, outs) {
    const gl = document.createElement('canvas').getContext('webgl2'), program = gl.createProgram();
    gl.getExtension('EXT_color_buffer_float');
    const shaders = [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]].map(([kind, source]) => {
        const shader = gl.createShader(kind);
        gl.shaderSource(shader, source);
        gl.compileShader(shader);
        gl.attachShader(program, shader);
        return shader;
    });
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS))
        return `${gl.getProgramInfoLog(program)} ${shaders.map((s) => gl.getShaderInfoLog(s)).join(' ')}`;
    gl.useProgram(program);
    const formats = { f: [gl.RGBA32F, gl.RGBA, gl.FLOAT], u: [gl.RGBA32UI, gl.RGBA_INTEGER, gl.UNSIGNED_INT], i: [gl.RGBA32I, gl.RGBA_INTEGER, gl.INT] };
    const samplers = new Map([[gl.SAMPLER_2D, ['f', gl.TEXTURE_2D]], [gl.UNSIGNED_INT_SAMPLER_2D, ['u', gl.TEXTURE_2D]], [gl.INT_SAMPLER_2D, ['i', gl.TEXTURE_2D]],
        [gl.SAMPLER_2D_ARRAY, ['f', gl.TEXTURE_2D_ARRAY]], [gl.UNSIGNED_INT_SAMPLER_2D_ARRAY, ['u', gl.TEXTURE_2D_ARRAY]]]);
    const texture = (kind, target) => {
        const made = gl.createTexture(), [internal, format, type] = formats[kind];
        gl.bindTexture(target, made);
        gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
        gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
        if (target === gl.TEXTURE_2D) gl.texImage2D(target, 0, internal, 1, 1, 0, format, type, null);
        else gl.texImage3D(target, 0, internal, 1, 1, 1, 0, format, type, null);
        return made;
    };
    for (let i = 0, unit = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i++) {
        const uniform = gl.getActiveUniform(program, i), sampler = samplers.get(uniform.type);
        if (!sampler) continue;
        gl.activeTexture(gl.TEXTURE0 + unit);
        texture(...sampler);
        gl.uniform1i(gl.getUniformLocation(program, uniform.name), unit++);
    }
    for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORM_BLOCKS); i++) {
        gl.uniformBlockBinding(program, i, i);
        gl.bindBufferBase(gl.UNIFORM_BUFFER, i, gl.createBuffer());
        gl.bufferData(gl.UNIFORM_BUFFER, gl.getActiveUniformBlockParameter(program, i, gl.UNIFORM_BLOCK_DATA_SIZE), gl.STATIC_DRAW);
    }
    gl.activeTexture(gl.TEXTURE15);
    gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
    outs.forEach((kind, i) => gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, texture(kind, gl.TEXTURE_2D), 0));
    gl.drawBuffers(outs.map((_, i) => gl.COLOR_ATTACHMENT0 + i));
    gl.viewport(0, 0, 1, 1);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    const [, format, type] = formats[outs[0]], pixel = { f: Float32Array, u: Uint32Array, i: Int32Array }[outs[0]];
    gl.readPixels(0, 0, 1, 1, format, type, new pixel(4));
    const error = gl.getError();
    return error ? `GL has the error ${error}` : '';
}

/* What a fragment shader writes: f, u or i for each of its outputs. */
const outsOf = (fragment) => [...fragment.matchAll(/^(?:layout\(location=\d+\))?\s*out (?:\w+ )?(\w+) \w+;/gm)].map((m) => ({ u: 'u', i: 'i' })[m[1][0]] || 'f');

let browser;
async function open() {
    await browser?.close();
    browser = await puppeteer.launch({ executablePath: process.env.CHROMIUM || '/usr/bin/chromium', headless: true, protocolTimeout: 300000,
        args: ['--no-sandbox', '--disable-dev-shm-usage', '--disable-gpu-watchdog', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'] });
    await seconds(screen, '#version 300 es\nprecision highp float;\nout vec4 result;\nvoid main() { result = vec4(1.0); }\n');
}

async function seconds(vertex, fragment) {
    const page = await browser.newPage(), before = taken();
    const wrong = await page.evaluate(draw, vertex, fragment, outsOf(fragment)), after = taken();
    await page.close();
    if (wrong) throw new Error(wrong);
    return after - before;
}

async function each_program_of_csm_compiles_in_2_seconds() {
    const slow = [];
    if (names.length < 8) throw new Error(`only ${names.length} programs in ${folder}`);
    await open();
    for (const name of names) {
        let took = await seconds(vertexOf(name), text(name)), longer = 1;
        for (let tries = 0; tries < 3 && took > LIMIT * longer; tries++) {
            await open();                           /* what it has compiled once may be kept */
            longer = Math.max(1, await seconds(screen, yardstick) / YARDSTICK);
            took = await seconds(vertexOf(name), text(name));
        }
        console.log(`${name}: ${took.toFixed(2)} s${longer > 1 ? `; the yardstick takes ${longer.toFixed(2)} times as long here` : ''}`);
        if (took > LIMIT * longer) slow.push(name);
    }
    if (slow.length) throw new Error(`more than ${LIMIT} s: ${slow.join(', ')}`);
}

const test = each_program_of_csm_compiles_in_2_seconds;
console.log(`[==========] Running 1 test(s).\n[ RUN      ] ${test.name}`);
try {
    await test();
    console.log(`[       OK ] ${test.name}`);
} catch (error) {
    console.log(`${error.message}\n[  FAILED  ] ${test.name}`);
    process.exitCode = 1;
}
await browser?.close();
console.log('[==========] 1 test(s) run.');
