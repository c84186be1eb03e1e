#!/bin/bash
#SBATCH --job-name={{ name }}
#SBATCH --nodes={{ nodes }}
#SBATCH --ntasks={{ ranks }}
{% if nodes > 1 %}
#SBATCH --ntasks-per-node={{ tasks }}
{% endif %}
#SBATCH --cpus-per-task=1
#SBATCH --mem-per-cpu={{ memory_per_rank }}M
#SBATCH --time={{ clock_limit }}
#SBATCH --signal=B:USR1@{{ notice }}
#SBATCH --open-mode=append
#SBATCH --output={{ folder }}/{{ "slurm-%A_%a.out" if runs | length > 1 else "slurm-%j.out" }}
{{ "#SBATCH --requeue" if requeues else "#SBATCH --no-requeue" }}
{% if queue %}
#SBATCH --partition={{ queue }}
{% endif %}
{% if account %}
#SBATCH --account={{ account }}
{% endif %}
{% if runs | length > 1 %}
#SBATCH --array=0-{{ runs | length - 1 }}
{% endif %}
{% include "batch/headers.sh" %}

{% include "batch/body.sh" %}
{% if requeues %}
if [ "$code" = 75 ]; then
    scontrol requeue "$SLURM_JOB_ID"
fi
{% endif %}
exit "$code"
