"""What this machine and this user give: caches, environments of child processes, terminals."""
