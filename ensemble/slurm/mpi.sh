#!/bin/sh
# A study as one MPI job: rank 0 hands out the runs, every rank writes its own files.
#
#     STUDY=mine.yaml OUT=/scratch/mine sbatch --nodes=4 ensemble/slurm/mpi.sh
#
# One rank a node, with a thread a core. A job that was cancelled or died keeps what is done; submit
# the same line again, or go on with array.sh or a plain `reckon run`.
#SBATCH --job-name=reckon
#SBATCH --ntasks-per-node=1
#SBATCH --cpus-per-task=64
#SBATCH --mem-per-cpu=500M
#SBATCH --time=24:00:00
#SBATCH --signal=TERM@60
#SBATCH --output=%x-%j.log

exec mpirun --map-by "node:PE=${SLURM_CPUS_PER_TASK:-1}" \
    "${RECKON:-reckon}" run "$STUDY" -o "$OUT" --threads "${SLURM_CPUS_PER_TASK:-1}"
