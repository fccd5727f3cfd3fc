// Empty: the source of the target that builds the precompiled header of all test programs.
