/* Stands in for what Simulink puts at the end of an S-function: its methods, for whoever calls them. */
#if !defined(S_FUNCTION_NAME) || S_FUNCTION_LEVEL != 2 || !defined(MDL_INITIALIZE_CONDITIONS) || !defined(MDL_UPDATE)
#error "no S-function of level 2 with a state"
#endif

const Methods s_function = {
    mdlInitializeSizes, mdlInitializeSampleTimes, mdlInitializeConditions, mdlOutputs, mdlUpdate, mdlTerminate,
};
