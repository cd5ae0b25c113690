/* stones.h - a made scene of many objects, for bake_ao. */
#ifndef BN_STONES_H
#define BN_STONES_H

enum { BN_STONES = 1000 };

int bn_stones_write(const char *path);      /* a .glb file; 0, or -1 after a line on stderr */

#endif
