// The program that embeds: it owns an OpenGL context and a framebuffer, and knows nothing of
// Perigee.
#ifndef HOST_H
#define HOST_H

// Makes a context current and binds a framebuffer of this size; 0, or 1 with a line on standard
// error.
int host_start(int width, int height);

// How many pixels of the framebuffer are not black.
int host_lit_pixels(void);

void host_stop(void);

#endif
