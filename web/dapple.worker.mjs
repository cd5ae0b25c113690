/* dapple.worker.mjs - the worker of dapple.mjs's build(). */
import { buildHere } from './dapple.mjs';

self.onmessage = async ({ data }) => {
    let told = 0;
    const onProgress = (fraction) => {
        if (fraction < told + 0.01) return;
        told = fraction;
        self.postMessage({ fraction });
    };
    const onThreads = (threads) => self.postMessage({ threads });
    try {
        const block = await buildHere(data.mesh, { ...data.options, onProgress, onThreads });
        self.postMessage({ block }, [block.buffer]);
    } catch (error) {
        self.postMessage({ error: error.message });
    }
};
