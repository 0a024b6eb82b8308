#!/bin/bash
# A run of several processes on a cluster with Slurm: sbatch examples/slurm.sh CASE DIR [options of `pellucid run`]
# Submitted again with the same DIR, it goes on from the last checkpoint there, with whatever number of processes.
#SBATCH --job-name=pellucid
#SBATCH --ntasks=8             # processes: each has its part of the memory
#SBATCH --cpus-per-task=8      # threads of each
#SBATCH --time=12:00:00
#SBATCH --signal=TERM@300      # five minutes before the time is up: a checkpoint is written, and the job ends with status 143
set -euo pipefail
if (($# < 2)); then
  echo "sbatch $0 CASE DIR [options of 'pellucid run']" >&2
  exit 2
fi
case=$1 dir=$2
shift 2

# mpi4py has to belong to the MPI of the cluster, and the environment and DIR have to lie on a disk that all machines see
source "${PELLUCID_ENVIRONMENT:-$HOME/pellucid/.venv}/bin/activate"
threads=${SLURM_CPUS_PER_TASK:-1}
export NUMBA_NUM_THREADS=$threads OMP_NUM_THREADS=$threads OMP_PROC_BIND=true
together=(srun --mpi="${PELLUCID_MPI:-pmix}" --cpus-per-task="$threads") # `srun --mpi=list` says which there are

if [[ -f $dir/case.toml ]]; then
  "${together[@]}" pellucid resume "$dir" --threads "$threads" --no-report
else
  "${together[@]}" pellucid run "$case" --out "$dir" --threads "$threads" --no-report "$@"
fi
pellucid report "$dir"
