"""The commands of `pellucid`, grouped by what they deal with; each module registers its own."""
