// Nothing: the source of the target whose precompiled header all test programs use.
