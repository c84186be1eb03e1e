#!/bin/bash
#SBATCH --job-name=bed
#SBATCH --nodes=2
#SBATCH --ntasks=8
#SBATCH --ntasks-per-node=4
#SBATCH --cpus-per-task=1
#SBATCH --mem-per-cpu=750M
#SBATCH --time=12:00:00
#SBATCH --signal=B:USR1@600
#SBATCH --open-mode=append
#SBATCH --output=/data/bed/batch/slurm-%j.out
#SBATCH --no-requeue
#SBATCH --partition=long
#SBATCH --account=beds
#SBATCH --constraint="milan|rome"
#SBATCH --qos=low
#SBATCH --mail-user=me@example.org
#SBATCH --mail-type=END,FAIL
#SBATCH --exclusive

# Without one of these the run would meet another solver, or none.
stop() { echo "fbcouple batch: '$1' failed with exit code $2; the run is not started" >&2; exit 3; }
module load openmpi/4.1 || stop 'module load openmpi/4.1' $?
eval 'source /opt/openfoam2512/etc/bashrc' || stop 'source /opt/openfoam2512/etc/bashrc' $?
set -u

# Neither code nor programs come from the folder that the job starts in: empty and relative entries mean that folder.
for name in PATH LD_LIBRARY_PATH PYTHONPATH; do
    given=${!name-} kept=
    if [ "$name" = LD_LIBRARY_PATH ]; then given=${given//;/:}; fi
    while IFS= read -r -d : entry; do
        case "$entry" in /*) kept="$kept:$entry" ;; esac
    done <<< "$given:"
    export "$name=${kept#:}"
done
export PATH="${PATH:-/usr/local/bin:/usr/bin:/bin}" PYTHONSAFEPATH=1
export FBCOUPLE_LAUNCHER=srun FBCOUPLE_BIND=core

runs=(
    /data/bed
)
run="${runs[${SLURM_ARRAY_TASK_ID:-0}]}"
state="$run/batch/state"
mkdir -p "$run/batch"

# What the job before left: nothing (this is the first), "running" (it was killed), 75 (stopped with a checkpoint); any
# other exit code is final, and a job that was handed in to go on has nothing to do.
left=$(cat "$state" 2>/dev/null)
case "$left" in
    "" | running | 75) ;;
    *) exit "$left" ;;
esac
how=()
if [ -d "$run/checkpoints" ]; then
    how=(--resume)
elif [ -n "$left" ]; then
    how=(--fresh)
fi
echo running > "$state"

job= noticed=
trap 'noticed=1; [ -z "$job" ] || kill -USR1 "$job" 2>/dev/null' USR1
trap 'noticed=1; [ -z "$job" ] || kill -TERM "$job" 2>/dev/null' TERM
/opt/venv/bin/python -m fbcouple.cli.main run "$run" -n 8 ${how[@]+"${how[@]}"} &
job=$!
if [ -n "$noticed" ]; then kill -USR1 "$job"; fi # it came before there was anybody to hand it on to
# A trapped signal ends `wait` early, with a code above 128; the run's own code is still to come.
while :; do
    noticed=
    wait "$job"
    code=$?
    if [ "$code" -le 128 ] || [ -z "$noticed" ]; then break; fi
done
case "$code" in
    138 | 143) code=75 ;; # ended by the notice before it could listen: no step was taken
esac
echo "$code" > "$state"
exit "$code"
