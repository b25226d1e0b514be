/* Numbers as text: one way to write them and one way to read them, the same in every locale (a
 * program that links this code may have set one with a decimal comma).
 *
 * Threads: no state. No allocation, no failure.
 */
#ifndef RK_BASE_NUMBER_H
#define RK_BASE_NUMBER_H

#include <stdbool.h>

enum { RK_NUMBER_TEXT = 32 };

/* Write x with the fewest digits, `least` to 17 of them, that read back to the same double; "nan",
 * "inf" and "-inf" for what is not finite. Returns `text`. */
const char *rk_number_text(double x, int least, char text[RK_NUMBER_TEXT]);

/* Read a decimal number that fills the whole text: no blanks, no hexadecimal, no words. Returns
 * false and leaves *x alone when it is none, or not finite. */
bool rk_number_read(const char *text, double *x);

/* x to `digits` (1 to 17) significant decimal digits. */
double rk_number_round(double x, int digits);

#endif
