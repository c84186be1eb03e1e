#!/bin/bash
# Hands in {{ jobs }} job{{ "s, each waiting for the one before" if jobs > 1 else "" }}; what is finished stays finished.
set -euo pipefail
{% for run in runs %}
rm -f {{ run | shell }}/batch/state
{% endfor %}
{{ first }}
echo "job $previous"
{% for job in range(1, jobs) %}
{{ next }}
echo "job $previous, after the one before"
{% endfor %}
