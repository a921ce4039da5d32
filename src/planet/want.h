// What somebody waits for: made by the asker, shared with the sources that work on it, and given up
// by a flag. A source that answers ERR_PENDING has taken a share of the want and gives it back when
// there is something new to ask for. Any thread.
#ifndef PERIGEE_PLANET_WANT_H
#define PERIGEE_PLANET_WANT_H

#include <stdbool.h>

struct want;

// priority: smaller is served first.
struct want *want_create(double priority);

// The asker's end: cancels what is still under way for this want alone. NULL-safe, nulls the
// pointer.
void want_release(struct want **want);
// The first half of it, from another thread of the asker's.
void want_cancel(struct want *want);

// Nothing is under way: ask again.
bool want_ready(const struct want *want);

// Waits until want_ready or `timeout_s` has passed; want_ready.
bool want_wait(struct want *want, double timeout_s);

// A source takes a share, looks whether the asker has gone, and gives the share back.
struct want *want_take(struct want *want);
bool want_cancelled(const struct want *want);
double want_priority(const struct want *want);
void want_give_back(struct want **want);

#endif
