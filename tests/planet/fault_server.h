// fault_server.py as a child of the test.
#ifndef PERIGEE_TESTS_FAULT_SERVER_H
#define PERIGEE_TESTS_FAULT_SERVER_H

#include <stddef.h>

// Starts it on any port (0), or again on the one it had. Exits with 77 where there is no python3.
int fault_server_start(int port);
void fault_server_stop(void);

// "http://127.0.0.1:PORT" and `path`, in one of a few rooms used in turn.
const char *fault_url(const char *path);

// Requests so far whose path begins with `part`.
int fault_server_seen(const char *part);
// The most that were answered at once.
int fault_server_most(void);
// Milliseconds, rounded up, between the n-th request for a path (from 0) and the next; -1: there
// was none.
int fault_server_pause(const char *path, int n);
// What /sick/ is from now on: a path without its slash, "ok" to be healthy.
void fault_server_sick(const char *kind);
// Should /down/ be dead?
void fault_server_down(int down);

#endif
