/* gl_backend.c - the one place where the programs compile gl_backend.h. */
#define GL_BACKEND_IMPLEMENTATION
#include "../../gl_backend.h"
