#!/bin/sh
# A study as a Slurm array job: every task carries out its part, all into one folder.
#
#     STUDY=mine.yaml OUT=/scratch/mine sbatch --array=1-32 ensemble/slurm/array.sh
#
# The part of a task depends on the plan alone. A task that was cancelled, ran out of time or died
# keeps what is done; submit the same line again and the job goes on from there. The folder must be
# on a file system that all nodes see.
#SBATCH --job-name=reckon
#SBATCH --cpus-per-task=8
#SBATCH --mem-per-cpu=500M
#SBATCH --time=24:00:00
#SBATCH --signal=TERM@60
#SBATCH --output=%x-%A-%a.log

exec "${RECKON:-reckon}" run "$STUDY" -o "$OUT" --threads "${SLURM_CPUS_PER_TASK:-1}" \
    --shard "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT"
