#!/bin/bash
#PBS -N {{ name }}
#PBS -l select=1:ncpus={{ ranks }}:mpiprocs={{ ranks }}:mem={{ memory }}mb
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

{% include "batch/body.sh" %}
exit "$code"
