"""The commands of `pellucid`, grouped by what they deal with."""
