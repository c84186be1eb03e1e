#!/bin/bash
#PBS -N {{ name }}
#PBS -l select={{ nodes }}:ncpus={{ tasks }}:mpiprocs={{ tasks }}:mem={{ memory_per_node }}mb
{% if nodes > 1 %}
#PBS -l place=scatter
{% endif %}
#PBS -l walltime={{ clock_limit }}
#PBS -j oe
#PBS -o {{ folder }}/
{% if queue %}
#PBS -q {{ queue }}
{% endif %}
{% if account %}
#PBS -A {{ account }}
{% endif %}
{% if runs | length > 1 %}
#PBS -J 0-{{ runs | length - 1 }}
{% endif %}
{% include "batch/headers.sh" %}

{% include "batch/body.sh" %}
exit "$code"
