"""Makes the modules of this folder that hold no tests (`algebra`, `small_cases`) importable from the tests below it."""
