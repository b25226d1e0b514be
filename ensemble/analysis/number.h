/* Numbers as text: the fewest of 15, 16 or 17 digits that read back to the same double. */
#ifndef RK_ENSEMBLE_ANALYSIS_NUMBER_H
#define RK_ENSEMBLE_ANALYSIS_NUMBER_H

enum { RK_NUMBER_TEXT = 32 };

/* "nan", "inf" and "-inf" for what is not finite. Returns `text`. */
const char *rk_number_text(double x, char text[RK_NUMBER_TEXT]);

/* Read a decimal number that fills the whole text: no blanks, no hexadecimal, no words.
 * Returns 0 and leaves *x alone when it is none, or not finite. */
int rk_number_read(const char *text, double *x);

#endif
