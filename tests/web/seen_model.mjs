// seen_model.mjs - node seen_model.mjs OUT.glb: a box on a floor, each its own object; every side of the box has its own
// square of the UV set.
import { writeFileSync } from 'node:fs';

const parts = [], views = [], accessors = [];
let size = 0;
function add(array, type, componentType, more) {
    const bytes = Buffer.from(array.buffer);
    views.push({ buffer: 0, byteOffset: size, byteLength: bytes.length });
    accessors.push({ bufferView: views.length - 1, componentType, count: array.length / { SCALAR: 1, VEC2: 2, VEC3: 3 }[type], type, ...more });
    parts.push(bytes);
    size += bytes.length;
    return accessors.length - 1;
}
// Squares of n x n quads: a corner, two edges, and a corner of the UV set.
function mesh(squares, n, uv_size) {
    const p = [], normals = [], uv = [], index = [];
    for (const [o, u, v, at] of squares) {
        const first = p.length / 3, face = [0, 1, 2].map(k => u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]);
        const length = Math.hypot(...face);
        for (let i = 0; i <= n; i++)
            for (let k = 0; k <= n; k++) {
                p.push(...[0, 1, 2].map(c => o[c] + u[c] * i / n + v[c] * k / n));
                normals.push(...face.map(x => x / length));
                uv.push(at[0] + uv_size * i / n, at[1] + uv_size * k / n);
            }
        for (let i = 0; i < n; i++)
            for (let k = 0; k < n; k++) {
                const a = first + i * (n + 1) + k, b = a + n + 1;
                index.push(a, b, a + 1, a + 1, b, b + 1);
            }
    }
    const low = [0, 1, 2].map(k => Math.min(...p.filter((_, i) => i % 3 === k))), high = [0, 1, 2].map(k => Math.max(...p.filter((_, i) => i % 3 === k)));
    return { primitives: [{ attributes: { POSITION: add(new Float32Array(p), 'VEC3', 5126, { min: low.map(Math.fround), max: high.map(Math.fround) }),
        NORMAL: add(new Float32Array(normals), 'VEC3', 5126), TEXCOORD_0: add(new Float32Array(uv), 'VEC2', 5126) },
        indices: add(new Uint32Array(index), 'SCALAR', 5125), material: 0 }] };
}
const floor = mesh([[[-1, 0, -1], [0, 0, 2], [2, 0, 0], [0.02, 0.02]]], 24, 0.96);
const box = mesh([[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.01, 0.01]], [[0, 0, -1], [0, 1, 0], [1, 0, 0], [0.34, 0.01]],
    [[0, 0, -1], [0, 0, 1], [0, 1, 0], [0.67, 0.01]], [[1, 0, -1], [0, 1, 0], [0, 0, 1], [0.01, 0.34]],
    [[0, 1, -1], [0, 0, 1], [1, 0, 0], [0.34, 0.34]]], 8, 0.31);
const json = Buffer.from(JSON.stringify({ asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0, 1, 2] }],
    nodes: [{ mesh: 0 }, { mesh: 1, translation: [-0.5, 0, 0], scale: [0.7, 0.7, 0.7], rotation: [0, 0.2588190451, 0, 0.9659258263] },
        { mesh: 1, translation: [0.35, 0, 0.6], scale: [0.3, 0.3, 0.3] }],
    meshes: [floor, box], materials: [{ name: 'plaster', pbrMetallicRoughness: { metallicFactor: 0, roughnessFactor: 1 } }],
    accessors, bufferViews: views, buffers: [{ byteLength: size }] }));
const text = Buffer.concat([json, Buffer.alloc((4 - json.length % 4) % 4, ' ')]), head = Buffer.alloc(20), middle = Buffer.alloc(8);
head.write('glTF');
head.writeUInt32LE(2, 4);
head.writeUInt32LE(28 + text.length + size, 8);
head.writeUInt32LE(text.length, 12);
head.write('JSON', 16);
middle.writeUInt32LE(size, 0);
middle.write('BIN\0', 4);
writeFileSync(process.argv[2], Buffer.concat([head, text, middle, ...parts]));
