"""Makes the modules of this folder that hold no tests (`algebra`, `scenes`) importable from the tests below it."""
