// Time that only grows, whatever happens to the wall clock. Any thread.
#ifndef PERIGEE_BASE_CLOCK_H
#define PERIGEE_BASE_CLOCK_H

// Seconds since an arbitrary start.
double clock_now_s(void);

// Lets the calling thread rest.
void clock_sleep_s(double seconds);

#endif
