// seen_maps.mjs - node seen_maps.mjs FOLDER STEM...: the light maps of STEM.glb, .exr and .hdr files, as three.js' own
// loaders read them: all have the same values, but for what each format can hold. Called by tests/scripts/seen.sh,
// which copies it beside three.js.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { FloatType } from 'three';
import { EXRLoader } from 'three/addons/loaders/EXRLoader.js';
import { HDRLoader } from 'three/addons/loaders/HDRLoader.js';

const [folder, ...stems] = process.argv.slice(2);
function materials(file) {
    const bytes = readFileSync(file);
    return JSON.parse(bytes.subarray(20, 20 + bytes.readUInt32LE(12))).materials;
}
// Rows from the top down, three values a texel; EXRLoader has the lowest row first.
function texels(uri) {
    const bytes = readFileSync(join(folder, decodeURIComponent(uri))), exr = uri.endsWith('.exr');
    const loader = exr ? new EXRLoader() : new HDRLoader();
    loader.setDataType(FloatType);
    const { width, height, data } = loader.parse(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength));
    const values = [];
    for (let y = 0; y < height; y++)
        for (let x = 0; x < width; x++)
            for (let k = 0; k < 3; k++) values.push(data[4 * ((exr ? height - 1 - y : y) * width + x) + k]);
    return values;
}
const maps = stems.map(stem => materials(join(folder, `${stem}.glb`)).filter(m => m.extras?.lightMapTexture).map(m => texels(m.extras.lightMapTexture.uri)));
let failed = 0;
for (let i = 1; i < stems.length; i++) {
    let worst = 0;
    const limit = stems[i].includes('hdr') ? 1 / 100 : 1 / 1500;       // three.js divides by 255, not 256
    maps[0].forEach((exact, m) => {
        for (let t = 0; t < exact.length; t += 3) {
            const most = Math.max(exact[t], exact[t + 1], exact[t + 2], 1e-4);
            for (let k = 0; k < 3; k++) worst = Math.max(worst, Math.abs(maps[i][m][t + k] - exact[t + k]) / most);
        }
    });
    const lit = maps[0].length === 2 && maps[0].every(m => Math.max(...m) > 0.01 && Math.max(...m) > Math.min(...m));
    const good = lit && worst <= limit && maps[i].every((m, k) => m.length === maps[0][k].length);
    console.log(`  ${good ? 'passed' : 'FAILED'}: ${stems[i]}, ${maps[0].length} maps as three.js reads them: ${worst.toExponential(1)} apart from floats`);
    failed += good ? 0 : 1;
}
process.exit(failed ? 1 : 0);
