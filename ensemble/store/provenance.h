/* What every file of the store says about where it comes from: parameters, seed, versions. */
#ifndef RK_ENSEMBLE_STORE_PROVENANCE_H
#define RK_ENSEMBLE_STORE_PROVENANCE_H

#include "ensemble/store/hdf5_file.h"
#include "ensemble/study.h"

/* The study, its identity and seed, and the versions of code and libraries, as attributes. */
void rk_provenance_study(struct rk_h5 *h5, hid_t object, const struct rk_plan *plan);

/* The same of one run, which does not depend on what else is in the study, nor on its name. */
void rk_provenance_run(struct rk_h5 *h5, hid_t object, const struct rk_plan *plan,
                       const struct rk_run *run);

/* The resolved parameters of a point, as groups and scalar datasets with units below `parent`. */
void rk_provenance_parameters(struct rk_h5 *h5, hid_t parent, const struct rk_study *study,
                              const struct rk_point *point);

/* Parameters as attributes of `object`, each as the text that a study file would have. */
void rk_provenance_notes(struct rk_h5 *h5, hid_t object, const struct rk_param_table *table,
                         const void *values);

#endif
