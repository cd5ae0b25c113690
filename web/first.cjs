/* first.cjs - node first.cjs product.wasm.js product.wasm.wasm: the coarse maps of the model that the page "product" begins with, built and
   packed by the page's own program, as a script that puts them beside it; product.js takes them. */
'use strict';
const { readFileSync } = require('node:fs');
const { resolve } = require('node:path');

const [script, wasm] = process.argv.slice(2).map((name) => resolve(name));
const model = 'builtin:knot', size = [16, 32], how = [1, 8, 8];       // as the page's sliders have it

/* The program is made for pages and workers; it takes this for a worker. */
globalThis.self = globalThis;
globalThis.importScripts = () => {};
globalThis.location = { href: 'file:///' };

function done(program) {
    const call = (name, types, values) => {
        if (program.ccall(`pd_${name}`, 'number', types, values) !== 0) throw new Error(program.ccall('pd_error', 'string', [], []));
    };
    call('load', ['string'], [model]);
    call('build', Array(5).fill('number'), [...size, ...how]);
    call('pack', [], []);
    const at = program.ccall('pd_packed', 'number', [], []), bytes = program.ccall('pd_packed_bytes', 'number', [], []);
    const block = Buffer.from(program.HEAPU8.slice(at, at + bytes)).toString('base64');
    process.stdout.write(`DappleProduct.first = ${JSON.stringify({ model, size, how, block })};\n`);
}

require(script)({ instantiateWasm: (imports, receive) => {
    const module = new WebAssembly.Module(readFileSync(wasm));
    receive(new WebAssembly.Instance(module, imports), module);
    return {};
} }).then(done);
