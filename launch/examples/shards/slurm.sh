#!/bin/bash
# A suite of zeronav as a job array of Slurm, one shard a task. Submit it, and merge when all are over. Single tasks
# are submitted again with ZERONAV_SHARDS=64 and --array=17; one at its time limit by `scontrol requeue`.
#
#   job=$(sbatch --parsable slurm.sh barn --seeds 10 --data /shared/data)
#   sbatch --dependency=afterok:"$job" --wrap "zeronav suite merge /shared/suite/$job/*/suite-* --out /shared/suite"
#
#SBATCH --job-name=zeronav-suite
#SBATCH --array=1-64
#SBATCH --cpus-per-task=1
#SBATCH --mem=2G
#SBATCH --time=01:00:00
#SBATCH --requeue
#SBATCH --open-mode=append
set -euo pipefail

out=${ZERONAV_OUT:-/shared/suite}/$SLURM_ARRAY_JOB_ID/$SLURM_ARRAY_TASK_ID
# A task that was started again goes on where it was.
begun=("$out"/suite-*/runs.jsonl)
if [ -e "${begun[0]}" ]; then
  exec zeronav suite --resume "$(dirname "${begun[0]}")" --jobs "${SLURM_CPUS_PER_TASK:-1}" --headless
fi
# What was killed before it had begun a journal is no shard.
rm -rf -- "$out"
exec zeronav suite "$@" --shard "$SLURM_ARRAY_TASK_ID/${ZERONAV_SHARDS:-$SLURM_ARRAY_TASK_COUNT}" \
  --jobs "${SLURM_CPUS_PER_TASK:-1}" --headless --out "$out"
