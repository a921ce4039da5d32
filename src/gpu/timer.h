// GPU time of named passes by timestamp queries, read some frames later without a wait. Begin a
// pass before it binds or clears its framebuffer, and give each pass a framebuffer of its own (or
// compute): between draws into one framebuffer a tiling driver, and so Mesa's software driver,
// stamps the time at which its last tile came there. Main only.
#ifndef PERIGEE_GPU_TIMER_H
#define PERIGEE_GPU_TIMER_H

enum { GPU_TIMER_PASSES = 8 };

struct gpu_timer;

struct gpu_timer *gpu_timer_create(void);
void gpu_timer_destroy(struct gpu_timer **timer);

void gpu_timer_begin(struct gpu_timer *timer, int pass);
void gpu_timer_end(struct gpu_timer *timer, int pass);

// Call once a frame, after its passes.
void gpu_timer_frame(struct gpu_timer *timer);

// Latest known time of a pass in milliseconds; negative while unknown.
double gpu_timer_ms(const struct gpu_timer *timer, int pass);

#endif
