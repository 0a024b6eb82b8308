#!/bin/bash
# A run of several processes on a cluster with Slurm: sbatch examples/slurm.sh CASE [options of `pellucid run`]
#SBATCH --job-name=pellucid
#SBATCH --ntasks=8             # processes: one for each part of a node's memory serves well
#SBATCH --cpus-per-task=8      # threads of each
#SBATCH --time=12:00:00
#SBATCH --signal=TERM@120      # two minutes before the time is up: a checkpoint is written, and the job ends with status 143
set -euo pipefail

# mpi4py has to be the one that was built with the MPI of the cluster, and the environment has to lie on a disk that all nodes see
source "${PELLUCID_ENVIRONMENT:-$HOME/pellucid/.venv}/bin/activate"
export NUMBA_NUM_THREADS=$SLURM_CPUS_PER_TASK OMP_NUM_THREADS=$SLURM_CPUS_PER_TASK OMP_PROC_BIND=true

case=$1
out=runs/$(basename "$case" .toml)-$SLURM_JOB_NAME
shift
if [[ -d $out/checkpoint ]]; then # the job before was stopped: go on where it was, with whatever number of processes
  srun pellucid resume "$out" --threads "$SLURM_CPUS_PER_TASK" --no-report
else
  pellucid warm "$case" # compiled once, not in every process at the same time
  srun pellucid run "$case" --out "$out" --threads "$SLURM_CPUS_PER_TASK" --no-report "$@"
fi
pellucid report "$out"
