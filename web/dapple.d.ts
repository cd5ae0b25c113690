/* dapple.d.ts - types of dapple.mjs. */
export interface Mesh {
    /** x, y, z of each vertex, in object space */
    positions: ArrayLike<number>;
    /** three to a triangle; without, vertices are taken three by three */
    indices?: ArrayLike<number> | null;
}

export interface BuildOptions {
    /** maps a side of the directions, 1 to 4096; 64 */
    side?: number;
    /** pixels a side of a map, 4 to 1024; 128 */
    mapSide?: number;
    /** cohsm_layers of csm.h; 0 = Z1Z2, right for every receiver */
    layers?: number;
    /** 1 to 8 threads where mayThread(); one for each processor. The block has the same bytes whatever the number */
    threads?: number;
    /** told once, when the build is done: how many threads took part */
    onThreads?: (threads: number) => void;
    /** 0 to 1, never falling. In buildHere false cancels */
    onProgress?: (fraction: number) => boolean | void;
}

/** Whether builds may use threads here: the page is cross-origin isolated. */
export function mayThread(): boolean;
/** Builds in a worker; the block is a file of csm.h. Rejects with a message that names what is wrong. */
export function build(mesh: Mesh, options?: BuildOptions & { signal?: AbortSignal }): Promise<Uint8Array>;
/** Builds in this thread. */
export function buildHere(mesh: Mesh, options?: BuildOptions): Promise<Uint8Array>;
/** Takes a context of yours. Two texture units from firstUnit (12) on and the binding firstBlock (6) are used. */
export function attach(context: WebGL2RenderingContext, options?: { firstUnit?: number; firstBlock?: number }): Promise<Attached>;

export interface Attached {
    maps(blocks: Uint8Array[], capacity?: number): Maps;
    glsl(options?: { uses?: string; defines?: string }): string;
    setSlots(program: WebGLProgram): void;
    free(options?: { lost?: boolean }): void;
}

export interface Maps {
    /** for Attached.glsl */
    readonly defines: string;
    /** rotation, one scale > 0, translation, column by column */
    place(instances: { block?: number; matrix: ArrayLike<number> & Iterable<number> }[]): void;
    bind(): void;
    free(): void;
}
