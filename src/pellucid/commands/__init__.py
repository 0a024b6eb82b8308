"""The commands of `pellucid`, grouped by topic."""
