// A web server on loopback that takes its time: /MS/PATH is the file PATH of its folder, after MS
// milliseconds. A process of its own.
#ifndef PERIGEE_BENCH_SLOW_SERVER_H
#define PERIGEE_BENCH_SLOW_SERVER_H

// Starts it, before there are threads. The port; 0 when it cannot start.
int slow_server_start(const char *folder);
void slow_server_stop(void);

#endif
