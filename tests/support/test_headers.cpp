// A source for the target that precompiles the headers of the tests.
