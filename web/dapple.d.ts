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

/** The library on a context of yours. */
export interface Attached {
    /** Uploads blocks, files of csm.h, with room for so many instances of them, of which none is placed yet. */
    maps(blocks: Uint8Array[], capacity?: number): Maps;
    /** The text of the library's functions, for a shader of GLSL ES 3.00: after `#version`, before functions of yours. */
    glsl(options?: {
        /** library files, by name and with spaces between; csm_visible */
        uses?: string;
        /** `NAME=value` with spaces between: Maps.defines makes the program fast, and right for such maps only */
        defines?: string;
    }): string;
    /** Once for each program that is linked with glsl(). */
    setSlots(program: WebGLProgram): void;
    /** Frees its maps and itself; call it once, and nothing else afterwards. lost: after the event webglcontextlost; then attach anew when the context is back. */
    free(options?: { lost?: boolean }): void;
}

/** Blocks on the GPU and where their objects stand. */
export interface Maps {
    /** for Attached.glsl */
    readonly defines: string;
    /** Replaces all instances; the shader counts them from 1. block: number in Attached.maps, 0; matrix: rotation, one scale > 0, translation, column by column. */
    place(instances: { block?: number; matrix: ArrayLike<number> & Iterable<number> }[]): void;
    /** Each frame, before your draws that ask; the units and the binding stay taken until somebody else takes them. */
    bind(): void;
    /** place and bind throw afterwards. A second call does nothing. */
    free(): void;
}
