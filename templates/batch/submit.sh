#!/bin/bash
# Hands in {{ jobs }} job{{ "s, each waiting for the one before" if jobs > 1 else "" }}; what is finished stays finished.
set -euo pipefail
if [ ! "$(dirname "${BASH_SOURCE[0]}")" -ef {{ folder | shell }} ]; then
    echo "$0: was written for "{{ folder | shell }}"; write it for this folder by: fbcouple batch" >&2
    exit 1
fi
for run in \
{% for run in runs %}
    {{ run | shell }}{{ ";" if loop.last else " \\" }}
{% endfor %}
do
    # How a run ended before does not count any more; one that goes on, or may, keeps what its job wrote.
    case "$(cat "$run/batch/state" 2>/dev/null)" in
        75) ;;
        running) echo "$run: a job has begun it; unless that one is over, a second one ends with exit code 69" ;;
        *) rm -f "$run/batch/state" ;;
    esac
done
{{ first }}
echo "job $previous"
{% for job in range(1, jobs) %}
{{ next }}
echo "job $previous, after the one before"
{% endfor %}
