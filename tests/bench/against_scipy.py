#!/usr/bin/env python3
"""Fit the same 1e6 samples with bench_pdf and with scipy (t.fit, gennorm.fit), CPU time of each.

    against_scipy.py BENCH_PDF [SAMPLES]      (Debian: python3-scipy; sh packages.sh peers)

bench_pdf fits both families with intervals; its whole time is set against each of scipy's fits, which
give no interval. The log-likelihoods of both answers are summed by scipy on the same samples.
"""
import subprocess
import sys
import tempfile
import time

import numpy
import scipy
from scipy import stats


def main():
    bench = sys.argv[1]
    count = int(float(sys.argv[2])) if len(sys.argv) > 2 else 1000000
    print(f"scipy {scipy.__version__}, {count} samples")
    rng = numpy.random.default_rng(1)
    cases = [
        ("q-Gaussian / t.fit", 0, stats.t, rng.standard_t(3, size=count)),
        ("stretched / gennorm.fit", 1, stats.gennorm,
         stats.gennorm.rvs(1.5, size=count, random_state=rng)),
    ]
    for name, family, distribution, x in cases:
        with tempfile.NamedTemporaryFile(suffix=".raw") as file:
            x.tofile(file.name)
            words = subprocess.run([bench, file.name, str(family)], check=True,
                                   capture_output=True, text=True).stdout.split()
        location, scale, shape, likelihood, ours = map(float, words)
        start = time.process_time()
        theirs = distribution.fit(x)
        seconds = time.process_time() - start
        if family == 0:  # q and s to nu and scipy's scale
            nu = (3 - shape) / (shape - 1)
            ours_as_theirs = (nu, location, scale / (3 - shape) ** 0.5)
        else:
            ours_as_theirs = (shape, location, scale)
        a = distribution.logpdf(x, *ours_as_theirs).sum()
        b = distribution.logpdf(x, *theirs).sum()
        print(f"{name}: {ours:.3f} s against {seconds:.2f} s, ratio {seconds / ours:.0f}; "
              f"log-likelihood {a:.4f} against {b:.4f}, {a - b:+.4f} (we say {likelihood:.4f})")


if __name__ == "__main__":
    main()
