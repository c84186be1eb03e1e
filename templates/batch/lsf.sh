#!/bin/bash
#BSUB -J "{{ name }}{{ "[1-%d]" | format(runs | length) if runs | length > 1 else "" }}"
#BSUB -n {{ ranks }}
#BSUB -R "span[{{ "hosts=1" if nodes == 1 else "ptile=%d" | format(tasks) }}]"
#BSUB -R "rusage[mem={{ memory_per_node }}MB]"
#BSUB -W {{ minutes_limit }}
#BSUB -wa USR1
#BSUB -wt {{ minutes_notice }}
#BSUB -o {{ folder }}/{{ "lsf-%J_%I.out" if runs | length > 1 else "lsf-%J.out" }}
{% if requeues %}
#BSUB -Q "75"
{% endif %}
{% if queue %}
#BSUB -q {{ queue }}
{% endif %}
{% if account %}
#BSUB -P {{ account }}
{% endif %}
{% include "batch/headers.sh" %}

{% include "batch/body.sh" %}
exit "$code"
