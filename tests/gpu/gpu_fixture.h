// The headless OpenGL context of a test program:
//     int rc = gpu_fixture_open();
//     if (rc) return rc;
//     rc = cmocka_run_group_tests(tests, NULL, NULL);
//     return gpu_fixture_close(rc);
#ifndef PERIGEE_TESTS_GPU_FIXTURE_H
#define PERIGEE_TESTS_GPU_FIXTURE_H

// Makes a debug context and makes it current. 0; 77 (with a message) where there is no EGL at all;
// 1 where there is one but no OpenGL 4.5 core.
int gpu_fixture_open(void);

// Destroys the context. `rc`, or 1 when a GL error was left behind or reported and not forgiven.
int gpu_fixture_close(int rc);

// How far the rasteriser may move a vertex on the screen, px: half a step of its grid of
// GL_SUBPIXEL_BITS both ways. 0 for Mesa's software, which interpolates as if it had moved none.
double gpu_fixture_snap_px(void);

// Forgets the GL errors so far: for tests that provoke them.
void gpu_fixture_forgive(void);

#endif
