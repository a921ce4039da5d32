// The shader files compiled into the program: a table ended by a NULL name.
#ifndef PERIGEE_GPU_EMBEDDED_H
#define PERIGEE_GPU_EMBEDDED_H

struct embedded_file {
    const char *name; // path below shaders/
    const char *text; // zero-terminated
};

extern const struct embedded_file embedded_files[];

#endif
