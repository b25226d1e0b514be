/* What a report has to say on the way: warnings, said by whoever asked for the report. */
#ifndef RK_ENSEMBLE_ANALYSIS_NOTICE_H
#define RK_ENSEMBLE_ANALYSIS_NOTICE_H

/* Told about what is left out or not drawn. NULL, or without a function, it is not told. */
struct rk_notice {
    void (*say)(void *context, const char *line);
    void *context;
};
void rk_notice_say(const struct rk_notice *notice, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

#endif
