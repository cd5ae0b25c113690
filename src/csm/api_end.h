#ifdef __cplusplus
}
#endif

#endif /* CSM_H */
