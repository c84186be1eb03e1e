{% for line in headers %}
{{ line }}
{% endfor %}
